"""Which loops only look for what others do, and what turns are counted for."""

import ast

import pytest

from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.marks.busy_waits import Looks, mark_turns
from tracerisk.instrument.tracer import Tracer

MODULE = """
class C:
    def ready(self): return self.pose is not None and self.enough()
    def enough(self):
        if self.n > 3: return True
        return False
    def step(self):
        self.n += 1
        return self.n < 9
    def first(self): self.second(); self.step()
    def second(self): self.first()
    def again(self): return self.done or self.again()
    def wait(self):
        while {test}:
            {body}
"""


def only_looks(test, body):
    tree = ast.parse(MODULE.format(test=test, body=body))
    loop = next(node for node in ast.walk(tree) if isinstance(node, ast.While))
    return Looks(tree).at(loop)


@pytest.mark.parametrize(
    ("test", "body"),
    [
        ("not self.done", "pass"),
        ("self.pose is None and not rospy.is_shutdown()", "continue"),
        ("rclpy.ok()", "'a remark'"),
        ("not self.ready()", "print('waiting', len(self.seen))"),
        ("True", "rospy.loginfo_throttle(1, f'waiting for {self.pose}')"),
        ("True", "if self.stopped: break"),
        ("True", "if self.ready(): return self.step()"),
        ("True", "if self.pose: self.step(); break"),
        ("True", "if self.pose: raise RuntimeError('no pose')"),
        ("a", "if a: pass\n            else: continue"),
        ("a", "while not b: pass"),
        ("not self.again()", "pass"),
        ("not future.done() and time.time() < end", "pass"),
    ],
)
def test_a_loop_that_changes_nothing_only_looks(test, body):
    assert only_looks(test, body)


@pytest.mark.parametrize(
    ("test", "body"),
    [
        ("a", "n += 1"),
        ("a", "work()"),
        ("a", "del a[0]"),
        ("a", "if a: work()"),
        ("a", "for x in a: pass"),
        ("self.step()", "pass"),
        ("not self.done", "print(self.step())"),
        ("robot.move()", "pass"),
        ("(x := f)", "pass"),
        ("self.second()", "pass"),
        ("not done", "if not at_goal: self.step(); continue\n            break"),
        ("a", "while b: self.step(); break"),
    ],
)
def test_a_loop_that_works_does_not(test, body):
    assert not only_looks(test, body)


def turns_of(tmp_path, source: str) -> list[int]:
    (tmp_path / "c.py").write_text(source)
    tracer, told = Tracer(), []
    tracer.on_turns = told.append
    run_controller(tmp_path / "c.py", tracer)
    return told


def test_turns_of_a_loop_that_works_are_told_by_the_hundred(tmp_path):
    assert turns_of(tmp_path, "n = 0\nwhile n < 250:\n    n += 1\n") == [100, 100]


def test_a_turn_of_a_loop_that_looks_counts_for_a_thousand(tmp_path):
    source = (
        "class Seen:\n    n = 0\n    def __bool__(self):\n        Seen.n += 1\n"
        "        return Seen.n > 2\nseen = Seen()\nwhile not seen:\n    pass\n"
    )
    assert turns_of(tmp_path, source) == [1000, 1000]


@pytest.mark.parametrize("decorator", ["njit", "numba.jit(nopython=True)"])
def test_a_function_that_is_compiled_is_left_as_it_is(decorator):
    source = f"@{decorator}\ndef f(n):\n    while n > 0:\n        n -= 1\n"
    tree = ast.parse(source)
    mark_turns(tree, "marks")
    assert ast.dump(tree) == ast.dump(ast.parse(source))
