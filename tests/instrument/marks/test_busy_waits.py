"""Which loops only look for what others do, and what turns are counted for."""

import ast

import pytest

from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.marks.busy_waits import mark_turns, only_looks
from tracerisk.instrument.tracer import Tracer


@pytest.mark.parametrize(
    "body",
    [
        "pass",
        "continue",
        "'a remark'",
        "print('waiting')",
        "rospy.loginfo_throttle(1, 'waiting')",
        "if self.stopped: break",
        "if self.pose: return self.pose",
        "if a: pass\n    else: continue",
        "while not b: pass",
    ],
)
def test_a_body_that_changes_nothing_only_looks(body):
    tree = ast.parse(f"def f():\n  while not done:\n    {body}\n")
    assert only_looks(tree.body[0].body[0].body)


@pytest.mark.parametrize(
    "body", ["n += 1", "work()", "del a[0]", "if a: work()", "for x in a: pass"]
)
def test_a_body_that_works_does_not(body):
    tree = ast.parse(f"def f():\n  while not done:\n    {body}\n")
    assert not only_looks(tree.body[0].body[0].body)


def turns_of(tmp_path, source: str) -> list[int]:
    (tmp_path / "c.py").write_text(source)
    tracer, told = Tracer(), []
    tracer.on_turns = told.append
    run_controller(tmp_path / "c.py", tracer)
    return told


def test_turns_of_a_loop_that_works_are_told_by_the_hundred(tmp_path):
    assert turns_of(tmp_path, "n = 0\nwhile n < 250:\n    n += 1\n") == [100, 100]


def test_a_turn_of_a_loop_that_looks_counts_for_a_thousand(tmp_path):
    source = "seen = iter([0, 0, 1])\nwhile not next(seen):\n    pass\n"
    assert turns_of(tmp_path, source) == [1000, 1000]


@pytest.mark.parametrize("decorator", ["njit", "numba.jit(nopython=True)"])
def test_a_function_that_is_compiled_is_left_as_it_is(decorator):
    source = f"@{decorator}\ndef f(n):\n    while n > 0:\n        n -= 1\n"
    tree = ast.parse(source)
    mark_turns(tree, "marks")
    assert ast.dump(tree) == ast.dump(ast.parse(source))
