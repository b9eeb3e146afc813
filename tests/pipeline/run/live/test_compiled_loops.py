"""Loops of C++ around a line, and which of them have no end of their own."""

import pytest

from tracerisk.adder.sources.c_source import parse_c
from tracerisk.pipeline.run.live.compiled_loops import loops_around

SOURCE = """\
int main()
{{
  {head} {{
    rate.sleep();
    {rest}
  }}{tail}
}}
"""
LINE = 4


def around(head, rest="", tail=""):
    source = parse_c(SOURCE.format(head=head, rest=rest, tail=tail).encode(), "cell.cpp")
    (function,) = source.functions
    return [(loop.first, loop.is_endless) for loop in loops_around(source, function, LINE)]


@pytest.mark.parametrize(
    "head",
    [
        *("while (true)", "while (1)", "for (;;)", "for (int i = 0;; ++i)", "while (ros::ok())"),
        *("while (rclcpp::ok(context))", "while (node->ok())", "while (ros::ok() && rclcpp::ok())"),
        *("while (!ros::isShuttingDown())", "while ((ros::ok()))"),
    ],
)
def test_a_loop_that_runs_as_long_as_the_program_may_is_endless(head):
    assert around(head) == [(3, True)]


def test_the_condition_of_a_do_loop_counts():
    assert around("do", tail=" while (ros::ok());") == [(3, True)]
    assert around("do", tail=" while (!done);") == [(3, False)]


@pytest.mark.parametrize(
    "head",
    [
        *("while (response.ok())", "while (planner->plan().ok())"),
        *("while (ros::ok() && !done)", "while (0)", "for (int i = 0; i < 9; ++i)"),
        *("for (const auto& part : parts)", "while (queue.pop())"),
    ],
)
def test_a_loop_with_another_condition_has_an_end(head):
    assert around(head) == [(3, False)]


@pytest.mark.parametrize(
    "rest",
    [
        *("break;", "return 0;", "throw 1;", "std::exit(1);", "ros::shutdown();", "goto out;"),
        *("if (done) break;", "if (ros::ok()) return 1;", "for (;;) return 1;"),
    ],
)
def test_what_leaves_a_loop_ends_it(rest):
    assert around("while (ros::ok())", rest) == [(3, False)]


@pytest.mark.parametrize(
    "rest",
    [
        *("if (!ros::ok()) break;", "if (!rclcpp::ok()) { return 1; } else { go(); }"),
        *("for (;;) { break; }", "switch (x) { case 1: break; }", "f([] { return 1; });"),
    ],
)
def test_what_leaves_something_else_or_at_the_shutdown_does_not(rest):
    assert around("while (ros::ok())", rest) == [(3, True)]


def test_an_inner_loop_comes_last():
    assert around("while (ros::ok()) for (int i = 0; i < 3; ++i)") == [(3, True), (3, False)]
