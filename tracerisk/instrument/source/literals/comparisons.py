"""What one comparison of a source compares, and the literals for which it holds."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.named_literals import literal_value

EMERGENCY = frozenset({"estop", "e_stop", "e-stop", "emergency_stop", "emergency"})
"""Words for the stop of an emergency, after which nothing is to move."""
_METHODS = frozenset({"lower", "upper", "strip", "rstrip", "lstrip", "title", "casefold"})
_CASTS = frozenset({"str", "int", "float", "bool", "round"})
_TAKES_STATES = frozenset({"set_named_target", "get_named_target_values"})
_STATE = "configuration_name"  # the keyword of `set_goal_state` of moveit_py


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant by its name, `GRASP` of `Task.GRASP`, whose value a message's text says."""

    name: str
    """The name of the constant."""


@dataclass(frozen=True)
class NamedState:
    """Any named state of a planning group, which the robot's description says."""

    owner: str
    """What is given the state in the source, `self.gripper` of `self.gripper.set_named_target`."""


def comparisons(node: ast.AST) -> Iterator[tuple[ast.expr | None, Any]]:
    """Yield what is compared and a literal for which the comparison holds."""
    for subject, value in compared(node):
        if not isinstance(value, Constant | NamedState):
            yield subject, value


def compared(node: ast.AST) -> Iterator[tuple[ast.expr | None, Any]]:
    """Yield what is compared and a literal or constant for which the comparison holds."""
    if isinstance(node, ast.Match):
        for case in node.cases:
            for pattern in ast.walk(case.pattern):
                if isinstance(pattern, ast.MatchValue):
                    yield from ((node.subject, literal) for literal in _literals(pattern.value))
        return
    if isinstance(node, ast.If | ast.IfExp) and (node.orelse or _returns_late(node)):
        yield from ((asserted(node.test), truth) for truth in (True, False))
        return
    if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Dict):
        yield from ((node.slice, key) for key in _keys(node.value))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
        if node.func.attr == "get" and isinstance(node.func.value, ast.Dict):
            yield from ((node.args[0], key) for key in _keys(node.func.value))
        if node.func.attr == "index" and isinstance(node.func.value, ast.List | ast.Tuple):
            yield from ((node.args[0], literal) for literal in _literals(node.func.value))
        if node.func.attr in ("startswith", "endswith"):
            yield from ((node.func.value, literal) for literal in _literals(node.args[0]))
        if node.func.attr in _TAKES_STATES:
            yield node.args[0], NamedState(dotted_name(node.func.value))
        return
    if isinstance(node, ast.keyword) and node.arg == _STATE:
        yield node.value, NamedState("")
    if not isinstance(node, ast.Compare) or len(node.ops) != 1:
        return
    left, operator, right = node.left, node.ops[0], node.comparators[0]
    if isinstance(operator, ast.Is | ast.IsNot):
        # `command is '1'` is meant as a comparison of texts or numbers.
        yield from ((left, literal) for literal in _literals(right) if _is_text_or_int(literal))
    elif isinstance(operator, ast.Eq | ast.NotEq | ast.In | ast.NotIn):
        # What is unequal is most often turned away.
        yield from ((left, literal) for literal in _literals(right))
        yield from ((right, literal) for literal in _literals(left) if isinstance(operator, ast.Eq))
        if isinstance(operator, ast.In):
            yield from (
                (right, literal) for literal in _literals(left) if not isinstance(literal, bool)
            )
    elif isinstance(operator, ast.Gt | ast.GtE):
        yield from (
            (left, beyond(literal, +1)) for literal in _literals(right) if is_number(literal)
        )
        yield from (
            (right, beyond(literal, -1)) for literal in _literals(left) if is_number(literal)
        )
    elif isinstance(operator, ast.Lt | ast.LtE):
        yield from (
            (left, beyond(literal, -1)) for literal in _literals(right) if is_number(literal)
        )
        yield from (
            (right, beyond(literal, +1)) for literal in _literals(left) if is_number(literal)
        )


def _is_text_or_int(value: object) -> bool:
    return isinstance(value, str | int) and not isinstance(value, bool)


def _returns_late(node: ast.AST) -> bool:
    """Return whether a branch does something and returns: what follows it is the other one."""
    if not isinstance(node, ast.If) or len(node.body) < 2:
        return False
    return isinstance(node.body[-1], ast.Return)


def asserted(test: ast.expr) -> ast.expr:
    """Return what a test asks, without a `not` before it."""
    return test.operand if isinstance(test, ast.UnaryOp) else test


def _keys(mapping: ast.Dict) -> Iterator[Any]:
    """Yield the keys of a mapping that are literals or constants."""
    yield from (literal for key in mapping.keys if key is not None for literal in _literals(key))


def _literals(node: ast.expr) -> Iterator[Any]:
    if isinstance(node, ast.List | ast.Tuple | ast.Set):
        named = [element for element in node.elts if _is_constant(element)]
        if named:
            yield from (literal for item in node.elts for literal in _literals(item))
            return
    if _is_constant(node):
        yield Constant(last_name(node))
        return
    value = literal_value(node)
    several = value if isinstance(value, list | tuple | set | dict) else (value,)
    if stops := EMERGENCY & {word for word in several if isinstance(word, str)}:
        # Other words listed with an emergency word mean the same.
        several = tuple(entry for entry in several if entry in stops)
    for entry in several:
        if isinstance(entry, bool | int | float | str) and entry != "":
            yield entry


def _is_constant(node: ast.expr) -> bool:
    return isinstance(node, ast.Attribute) and node.attr.isupper()


def is_number(value: Any) -> bool:
    """Return whether a literal is a number, and no truth value."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def beyond(value: float, side: int) -> float:
    """Return a number that is above a bound, where `side` is +1, or below it, where it is -1."""
    return value + side * max(abs(value) / 10, 1 if isinstance(value, int) else 0.1)


def bare_value(node: ast.expr) -> ast.expr:
    """Return an expression without the conversions around it: `str(a.b).lower()` is `a.b`."""
    while isinstance(node, ast.Call):
        if isinstance(node.func, ast.Attribute) and node.func.attr in _METHODS:
            node = node.func.value
        elif _is_cast(node) and len(node.args) == 1:
            node = node.args[0]
        else:
            break
    return node


def _is_cast(call: ast.Call) -> bool:
    """Return whether a call keeps what a value says: `int(a)`, and `Task(a)` of an Enum."""
    return last_name(call.func) in _CASTS or (
        isinstance(call.func, ast.Name) and call.func.id[:1].isupper() and not call.keywords
    )
