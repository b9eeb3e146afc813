"""Which loops of C and C++ are around a line, and which of them have no end of their own.

The rule is that of Python (`instrument/marks/endless_loops.py`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.adder.sources.c_source import CFunction, CSource

if TYPE_CHECKING:
    from tree_sitter import Node

_LOOPS = frozenset({"for_statement", "for_range_loop", "while_statement", "do_statement"})
_EXITS = frozenset(
    {"exit", "_exit", "_Exit", "quick_exit", "abort", "terminate", "shutdown", "requestShutdown"}
)
_LEAVING = frozenset(
    {"return_statement", "goto_statement", "throw_statement", "co_return_statement"}
)
_OF_ROS = re.compile(r"ros|rclcpp|n_?|nh\w*|\w*node\w*", re.IGNORECASE)
_IS_SHUTTING_DOWN = "isShuttingDown"


@dataclass(frozen=True, slots=True)
class CLoop:
    """A loop of a function."""

    first: int
    """Its first line."""
    last: int
    """Its last line."""
    is_endless: bool
    """Whether it goes on until the program is shut down."""


def loops_around(source: CSource, function: CFunction, line: int) -> Iterator[CLoop]:
    """Yield the loops of a function around one of its lines, the outermost first."""
    waiting: list[Node] = [source.tree.root_node]
    while waiting:
        node = waiting.pop()
        first, last = node.start_point.row + 1, node.end_point.row + 1
        if not first <= line <= last:
            continue
        if node.type in _LOOPS and function.start <= node.start_byte < function.end:
            yield CLoop(first, last, _is_endless(node))
        waiting += node.named_children


def _is_endless(loop: Node) -> bool:
    test, body = loop.child_by_field_name("condition"), loop.child_by_field_name("body")
    if loop.type == "for_range_loop" or body is None:
        return False
    holds = loop.type == "for_statement" if test is None else _holds(test)
    return holds and not _leaves(body, inner=False)


def _holds(test: Node) -> bool:
    """Return whether a condition holds until the program is shut down."""
    value = test.child_by_field_name("value")
    if test.type in ("condition_clause", "parenthesized_expression"):
        inside = value or next(iter(test.named_children), None)
        return inside is not None and _holds(inside)
    if test.type == "binary_expression":
        left, right = test.child_by_field_name("left"), test.child_by_field_name("right")
        by = test.child_by_field_name("operator")
        if left is None or right is None or by is None or by.type not in ("&&", "||"):
            return False
        held = _holds(left), _holds(right)
        return any(held) if by.type == "||" else all(held)
    if test.type == "unary_expression":
        of = test.child_by_field_name("argument")
        return of is not None and _called(of) == _IS_SHUTTING_DOWN
    if test.type == "number_literal":
        return _text(test) not in ("0", "")
    return test.type == "true" or _is_ok_of_ros(test)


def _is_over(test: Node) -> bool:
    """Return whether a condition holds only when the program is shut down."""
    inside = next(iter(test.named_children), None)
    if test.type in ("condition_clause", "parenthesized_expression"):
        return inside is not None and _is_over(inside)
    if test.type == "unary_expression":
        of = test.child_by_field_name("argument")
        return of is not None and _is_ok_of_ros(of)
    return _called(test) == _IS_SHUTTING_DOWN


def _leaves(node: Node, *, inner: bool) -> bool:
    """Return whether something in a loop's body leaves the loop; `inner`: within another one."""
    if node.type in _LEAVING or (node.type == "break_statement" and not inner):
        return True
    if node.type == "lambda_expression":
        return False
    if node.type == "call_expression" and _called(node) in _EXITS:
        return True
    parts = node.named_children
    if node.type == "if_statement":
        test = node.child_by_field_name("condition")
        if test is not None and _is_over(test):
            other = node.child_by_field_name("alternative")
            parts = [] if other is None else [other]
    within = inner or node.type in _LOOPS or node.type == "switch_statement"
    return any(_leaves(part, inner=within) for part in parts)


def _is_ok_of_ros(node: Node) -> bool:
    """Return whether an expression asks ROS or a node for `ok()`, and no status of a library."""
    owner, _, name = _path_called(node).rpartition(".")
    return name == "ok" and _OF_ROS.fullmatch(owner.rpartition(".")[2]) is not None


def _called(node: Node) -> str:
    """Return the last name of what an expression calls; empty if it is no call."""
    return _path_called(node).rpartition(".")[2]


def _path_called(node: Node) -> str:
    """Return what an expression calls, with dots for all that joins names; empty for no call."""
    function = node.child_by_field_name("function") if node.type == "call_expression" else None
    return "" if function is None else _text(function).replace("->", ".").replace("::", ".")


def _text(node: Node) -> str:
    return (node.text or b"").decode("utf-8", "replace")
