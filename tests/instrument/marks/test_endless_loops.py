"""Which loops have no end of their own, and where their iterations are told."""

import ast
import textwrap
from pathlib import Path

import pytest

from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.marks.endless_loops import endless_loops
from tracerisk.instrument.tracer import Tracer


def lines(source: str) -> list[int]:
    return sorted(loop.lineno for loop in endless_loops(ast.parse(textwrap.dedent(source))))


@pytest.mark.parametrize(
    "condition",
    ["True", "1", "not rospy.is_shutdown()", "rclpy.ok()", "rclpy.ok() and True", "x or True"],
)
def test_a_condition_that_holds_until_the_shutdown_makes_a_loop_endless(condition):
    assert lines(f"while {condition}:\n    work()\n") == [1]


@pytest.mark.parametrize(
    "condition", ["False", "n < 3", "rclpy.ok() and n < 3", "not done", "not a.is_shutdown() and b"]
)
def test_another_condition_is_an_end_of_its_own(condition):
    assert lines(f"while {condition}:\n    work()\n") == []


@pytest.mark.parametrize(
    "leave", ["break", "sys.exit()", "rospy.signal_shutdown('done')", "rclpy.shutdown()"]
)
def test_what_leaves_the_loop_is_an_end(leave):
    assert lines(f"while True:\n    if work():\n        {leave}\n") == []


def test_a_return_is_an_end_and_one_of_a_function_within_is_none():
    assert lines("def f():\n    while True:\n        return 1\n") == []
    assert lines("while True:\n    def f():\n        return 1\n    f()\n") == [1]


def test_a_break_of_an_inner_loop_leaves_only_that():
    source = """\
    while True:
        for each in poses:
            break
        while True:
            break
    """
    assert lines(source) == [1]


@pytest.mark.parametrize(
    "source",
    [
        "while True:\n    try:\n        work()\n    except KeyboardInterrupt:\n        break\n",
        "while True:\n    if rospy.is_shutdown():\n        break\n    work()\n",
        "while True:\n    if not rclpy.ok():\n        break\n    work()\n",
    ],
)
def test_what_only_a_shutdown_reaches_is_no_end(source):
    assert lines(source) == [1]


def test_each_iteration_is_reported_with_file_and_line(tmp_path: Path):
    (tmp_path / "c.py").write_text(
        '"""A docstring."""\nfrom __future__ import annotations\n\n'
        "def f(n=[]):\n    while True:\n        n.append(1)\n        1 / (3 - len(n))\n\n"
        "try:\n    f()\nexcept ZeroDivisionError:\n    pass\n"
    )
    reported: list[tuple[str, int]] = []
    tracer = Tracer()
    tracer.on_iteration = lambda file, line: reported.append((file, line))
    run_controller(tmp_path / "c.py", tracer, root=tmp_path)
    assert reported == [("c.py", 5)] * 3
