"""What a source does with what a call gives it, such as `input` or `get_param`.

Read from the source alone, by the names that hold the result.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Set
from functools import lru_cache, partial
from typing import Any, Literal

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.called_functions import (
    calls_at,
    functions_of,
    parameter_name,
    source_tree,
)
from tracerisk.instrument.source.literals.comparisons import (
    asserted,
    bare_value,
    comparisons,
)

_FURTHEST = 3  # functions through which a result is followed
_CASTS = frozenset({"str", "int", "float", "bool", "round"})
_NAMED = frozenset(
    {
        "MoveGroupCommander",
        "MoveGroup",
        "Subscriber",
        "Publisher",
        "ServiceProxy",
        "lookup_transform",
        "wait_for_service",
        "wait_for_message",
        "SimpleActionClient",
        "open",
        "get_planning_component",
    }
)
Shape = Literal["", "joints", "list", "list of joints", "mapping"]
"""What a result is made of, as far as its use says."""
_TARGET = "set_joint_value_target"
_THROUGH = frozenset({"enumerate", "reversed", "zip"})
_OTHER_SIDE: Mapping[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt,
}  # fmt: skip


def compared_results(place: Location | None, call: str) -> tuple[Any, ...]:
    """Return the literals with which the result of the `call` at `place` is compared.

    A number comes first where the result is made one and no number is compared with it.
    """
    for tree, node in calls_of(place, call):
        result, casts = _compared_with(tree, node)
        if {"int", "float"} & casts and not any(map(_is_number, result)):
            result.insert(0, 1 if "int" in casts else 0.5)
        if result:
            return tuple(dict.fromkeys(result))
    return ()


def results_of_name(place: Location | None, name: str, calls: Collection[str]) -> tuple[Any, ...]:
    """Return the literals with which a source compares what any of `calls` returns for a name."""
    tree = source_tree(place)
    result: list[Any] = []
    for node in ast.walk(tree) if tree is not None else ():
        is_read = isinstance(node, ast.Call) and last_name(node.func) in calls and node.args
        first = node.args[0] if is_read and isinstance(node, ast.Call) else None
        text = first.value if isinstance(first, ast.Constant) else None
        is_of_name = isinstance(text, str) and re.split(r"[/.~]", text)[-1] == name
        if tree is not None and isinstance(node, ast.Call) and is_of_name:
            result += _compared_with(tree, node)[0]
    return tuple(dict.fromkeys(result))


def _compared_with(tree: ast.Module, call: ast.Call) -> tuple[list[Any], Set[str]]:
    """Return the literals with which the result of a call is compared, and its conversions."""
    names, casts = held_by(tree, call)
    refused = _refused(tree)
    result = [
        value
        for node in ast.walk(tree)
        if isinstance(node, ast.Compare | ast.Match)
        or (isinstance(node, ast.Call) and last_name(node.func) == "index")
        for subject, value in comparisons(refused.get(id(node), node))
        if subject is not None and is_held(subject, call, names)
    ]
    return result, casts


def _is_number(value: Any) -> bool:
    """Return whether a value is a number, or a text of one."""
    try:
        float(value)
    except (TypeError, ValueError):
        return False
    return True


def _refused(tree: ast.AST) -> dict[int, ast.Compare]:
    """Return what holds instead of each comparison (by `id`) that turns a number away.

    That is the test of an `if` that raises, or goes on to the next round of a loop, and that of a
    loop which asks again.
    """
    return {
        id(test): ast.Compare(test.left, [_OTHER_SIDE[type(test.ops[0])]()], test.comparators)
        for node in ast.walk(tree)
        if (isinstance(node, ast.If) and isinstance(node.body[-1], ast.Continue | ast.Raise))
        or (isinstance(node, ast.While) and _asks(node))
        for test in [node.test]
        if isinstance(test, ast.Compare) and len(test.ops) == 1 and type(test.ops[0]) in _OTHER_SIDE
    }


def _asks(loop: ast.While) -> bool:
    return any(
        isinstance(node, ast.Call) and last_name(node.func) == "input" for node in ast.walk(loop)
    )


def used_as(place: Location | None, call: str) -> str:
    """Return as what the result of the `call` at `place` is used: `int`, `bool`, ..., or empty.

    By the conversions around it, and by what it is joined, reckoned or counted with.
    """
    for tree, node in calls_of(place, call):
        names, casts = held_by(tree, node)
        for kind in ("int", "float", "str"):
            if kind in casts:
                return kind
        is_it = lambda item: item is node or dotted_name(item) in names  # noqa: B023, E731
        for item in ast.walk(tree):
            use = _use(item, is_it)
            if use:
                return use
    return ""


def shape_of(place: Location | None, call: str) -> tuple[Shape, tuple[str, ...]]:
    """Return of which shape the result of the `call` at `place` is, and the keys of a mapping.

    By what takes it: a motion to joints, a loop over it, an index that is a word. "" is unknown.
    """
    for tree, node in calls_of(place, call):
        names, _ = held_by(tree, node)
        # Its parts are held by names of their own, which say nothing of the whole.
        whole = names - _names_of_parts(tree, names)
        is_it = partial(_is_held_whole, node, whole)
        taken = [item for item in ast.walk(tree) if isinstance(item, ast.Call) and _to_joints(item)]
        keys = tuple(
            dict.fromkeys(
                item.slice.value
                for item in ast.walk(tree)
                if isinstance(item, ast.Subscript)
                and is_it(item.value)
                and isinstance(item.slice, ast.Constant)
                and isinstance(item.slice.value, str)
            )
        )
        if keys:
            return "mapping", keys
        if any(is_it(one.args[0]) for one in taken):
            return "joints", ()
        for loop in ast.walk(tree):
            if isinstance(loop, ast.For | ast.comprehension) and _goes_through(loop.iter, is_it):
                names = {item.id for item in ast.walk(loop.target) if isinstance(item, ast.Name)}
                to_joints = any(dotted_name(one.args[0]) in names for one in taken)
                return ("list of joints" if to_joints else "list"), ()
    return "", ()


def _to_joints(call: ast.Call) -> bool:
    """Return whether a call takes joints first; `set_joint_value_target(name, value)` does not."""
    name = last_name(call.func)
    return bool(call.args) and (name == "go" or (name == _TARGET and len(call.args) == 1))


def _is_held_whole(call: ast.Call, names: Collection[str], item: ast.AST) -> bool:
    return item is call or dotted_name(item) in names


def _names_of_parts(tree: ast.Module, names: Collection[str]) -> set[str]:
    """Return the names among those given that a part of what others hold is assigned to."""
    return {
        dotted_name(target)
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and isinstance(bare_value(node.value), ast.Subscript)
        for target in node.targets
        if dotted_name(target) in names
    }


def _goes_through(iterated: ast.expr, is_it: Callable[[ast.AST], bool]) -> bool:
    if isinstance(iterated, ast.Call) and last_name(iterated.func) in _THROUGH:
        return any(map(is_it, iterated.args))
    return is_it(iterated)


def _use(node: ast.AST, is_it: Callable[[ast.AST], bool]) -> str:
    if isinstance(node, ast.If | ast.While | ast.IfExp) and is_it(asserted(node.test)):
        return "bool"
    if isinstance(node, ast.BinOp) and (is_it(node.left) or is_it(node.right)):
        other = node.right if is_it(node.left) else node.left
        if isinstance(other, ast.JoinedStr) or (
            isinstance(other, ast.Constant) and isinstance(other.value, str)
        ):
            return "str"
        return "float" if isinstance(node.op, ast.Mult | ast.Div | ast.Sub) else ""
    if isinstance(node, ast.FormattedValue) and is_it(node.value):
        return "str"
    if isinstance(node, ast.Call) and any(is_it(argument) for argument in node.args):
        name = last_name(node.func)
        if name == "range":
            return "int"
        if name in ("Rate", "Duration", "sleep"):
            return "float"
        if name in _NAMED:
            return "str"
    return ""


def written_name(place: Location | None, call: str) -> str:
    """Return the text that the `call` at `place` has as its first argument; empty for none."""
    for _, node in calls_of(place, call):
        first = node.args[0] if node.args else None
        if isinstance(first, ast.Constant):
            return str(first.value) if isinstance(first.value, str) else ""
    return ""


@lru_cache(maxsize=64)
def held_by(tree: ast.AST, call: ast.Call) -> tuple[Set[str], Set[str]]:
    """Return the names that are given what a call returns, and the conversions around it.

    Also where a function of the same source returns it, or is handed it.
    """
    names: set[str] = set()
    casts: set[str] = set()
    functions = functions_of(tree)
    returning: set[str] = set()

    def holds(value: ast.expr) -> bool:
        inside = any(item is call for item in ast.walk(value))
        stem = _stem(value)
        is_returned = isinstance(stem, ast.Call) and last_name(stem.func) in returning
        return inside or is_returned or dotted_name(stem) in names

    for _ in range(_FURTHEST):
        before = len(names), len(returning)
        for node in ast.walk(tree):
            if isinstance(node, ast.Assign | ast.AnnAssign | ast.NamedExpr):
                if node.value is None or not holds(node.value):
                    continue
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names |= {dotted_name(target) for target in targets if dotted_name(target)}
            elif isinstance(node, ast.FunctionDef):
                returns = (item.value for item in ast.walk(node) if isinstance(item, ast.Return))
                if any(value is not None and holds(value) for value in returns):
                    returning.add(node.name)
            elif isinstance(node, ast.Call) and last_name(node.func) in functions:
                callee = functions[last_name(node.func)]
                given = enumerate(node.args)
                taken = (parameter_name(callee, index) for index, value in given if holds(value))
                names |= {name for name in taken if name is not None}
        if (len(names), len(returning)) == before:
            break
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and last_name(node.func) in _CASTS and node.args:
            inner = node.args[0]
            if any(item is call for item in ast.walk(inner)) or dotted_name(inner) in names:
                casts.add(last_name(node.func))
    return frozenset(names), frozenset(casts)


def is_held(node: ast.expr, call: ast.Call, names: Set[str]) -> bool:
    """Return whether an expression is what a call returns, or a part of it: `names` hold that."""
    stem = _stem(node)
    return stem is call or dotted_name(stem) in names


def _stem(node: ast.expr) -> ast.expr:
    """Return an expression without what takes a part of it: `answer.split()[0]` is `answer`."""
    while True:
        bare = bare_value(node)
        is_split = isinstance(bare, ast.Call) and last_name(bare.func) in ("split", "splitlines")
        if isinstance(bare, ast.Subscript | ast.NamedExpr):
            node = bare.value
        elif is_split and isinstance(bare.func, ast.Attribute):  # type: ignore[attr-defined]
            node = bare.func.value  # type: ignore[attr-defined]
        else:
            return bare


def calls_of(place: Location | None, name: str) -> Iterator[tuple[ast.Module, ast.Call]]:
    """Yield the calls of a name that stand at a place, each with the tree of its source."""
    tree = source_tree(place)
    for call in () if tree is None or place is None else calls_at(tree, place.line):
        if tree is not None and last_name(call.func) == name:
            yield tree, call
