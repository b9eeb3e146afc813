"""Answers that code takes apart into numbers: `[float(each) for each in input("> ").split()]`."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.called_functions import calls_at, source_tree
from tracerisk.ros.drafts.asked_results import held_by
from tracerisk.ros.drafts.named_numbers import Units, numbers_in_place, units_of
from tracerisk.ros.drafts.said_around import said_at
from tracerisk.ros.drafts.usable_values import UsableValues

_NUMBERS = ("float", "int")


@dataclass(frozen=True, slots=True)
class _Split:
    """How code splits an answer into numbers."""

    count: int
    """The number of parts; 0 where the code does not show it."""
    separator: str
    """The text between two parts."""
    is_whole: bool
    """Whether every part becomes a whole number."""


def numbers_answer(place: Location | None, values: UsableValues) -> str | None:
    """Return the numbers for the `input` at `place`, if its code takes the answer apart into some.

    As many as the arm has joints are positions of these [rad or m]; three are a position that the
    tool reaches [m], six it and roll, pitch and yaw [rad], seven it and a quaternion; in degrees
    and millimetres where the source says so.
    """
    split = _split_at(place)
    if split is None:
        return None
    units = units_of("", said_at(place))
    numbers = _numbers(split.count or len(values.joints), values, units)
    texts = [str(round(number)) if split.is_whole else f"{number + 0.0:.4g}" for number in numbers]
    return split.separator.join(texts)


def _numbers(count: int, values: UsableValues, units: Units) -> Sequence[float]:
    numbers = numbers_in_place(count, units, values.reach)
    if numbers is not None:
        return numbers
    position, turn = values.pose.position, values.pose.orientation
    whole = (*(units.length(value) for value in position), *turn)
    return whole if count == len(whole) else (0.1,) * count


def _split_at(place: Location | None) -> _Split | None:
    tree = source_tree(place)
    if tree is None or place is None:
        return None
    for call in calls_at(tree, place.line):
        if last_name(call.func) == "input":
            around = _around(tree, call)
            names, _ = held_by(around, call)
            for node in ast.walk(around):
                if _is_split(node) and _is_of(node, call, names):
                    split = _taken_apart(node, around)
                    if split is not None:
                        return split
    return None


def _around(tree: ast.Module, call: ast.Call) -> ast.AST:
    """Return the innermost loop or function that holds a call: names mean others elsewhere."""
    holding = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.While | ast.For | ast.FunctionDef | ast.AsyncFunctionDef)
        and any(item is call for item in ast.walk(node))
    ]
    return holding[-1] if holding else tree


def _is_split(node: ast.AST) -> bool:
    is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    return is_method and last_name(node.func) == "split"  # type: ignore[attr-defined]


def _is_of(split: ast.AST, call: ast.Call, names: Set[str]) -> bool:
    assert isinstance(split, ast.Call)
    return any(
        node is call or (isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in names)
        for node in ast.walk(split.func)
    )


def _taken_apart(split: ast.AST, around: ast.AST) -> _Split | None:
    assert isinstance(split, ast.Call)
    parts = [split, *_named(around, _targets(around, split))]
    made = [
        (node, cast)
        for node in ast.walk(around)
        for cast in [_cast(node)]
        if cast and any(part is item for part in parts for item in ast.walk(node))
    ]
    if not made:
        return None
    names = _targets(around, split)
    for node, _ in made:
        names |= _targets(around, node)
    given = split.args[0] if split.args else None
    separator = given.value if isinstance(given, ast.Constant) else " "
    count = next(_counts(around, names), 0)
    return _Split(count, str(separator), all(cast == "int" for _, cast in made))


def _cast(node: ast.AST) -> str:
    """Return to which number a comprehension, a `map` or a conversion makes what it is given."""
    if isinstance(node, ast.ListComp | ast.GeneratorExp):
        node = node.elt
    elif isinstance(node, ast.Call) and last_name(node.func) == "map" and node.args:
        name = last_name(node.args[0])
        return name if name in _NUMBERS else ""
    is_call = isinstance(node, ast.Call) and len(node.args) == 1
    name = last_name(node.func) if is_call else ""  # type: ignore[attr-defined]
    return name if name in _NUMBERS else ""


def _named(around: ast.AST, names: set[str]) -> Iterator[ast.AST]:
    for node in ast.walk(around):
        if isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load):
            yield node


def _targets(around: ast.AST, value: ast.AST) -> set[str]:
    """Return the names that are given something made of a value."""
    return {
        ast.unparse(target)
        for node in ast.walk(around)
        if isinstance(node, ast.Assign) and any(item is value for item in ast.walk(node.value))
        for target in node.targets
    }


def _counts(around: ast.AST, names: set[str]) -> Iterator[int]:
    """Yield how many parts the code wants: by names, by `len`, by the last that is read."""
    for name in sorted(names):
        if "," in name:
            yield len(ast.parse(name.strip("()[]")).body[0].value.elts)  # type: ignore[attr-defined]
    for node in ast.walk(around):
        if isinstance(node, ast.Compare) and isinstance(node.left, ast.Call):
            is_length = last_name(node.left.func) == "len" and len(node.left.args) == 1
            wanted = node.comparators[0]
            if is_length and ast.unparse(node.left.args[0]) in names:
                if isinstance(wanted, ast.Tuple | ast.List | ast.Set) and wanted.elts:
                    wanted = wanted.elts[0]
                if isinstance(wanted, ast.Constant) and isinstance(wanted.value, int):
                    yield wanted.value
    read = [
        node.slice.value
        for node in ast.walk(around)
        if isinstance(node, ast.Subscript)
        and ast.unparse(node.value) in names
        and isinstance(node.slice, ast.Constant)
        and isinstance(node.slice.value, int)
    ]
    if read:
        yield max(read) + 1
