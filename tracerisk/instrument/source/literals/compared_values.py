"""With which literals a source compares what it is given: fields of messages, parameters, answers.

Read from the source alone. A name that is given a field's value stands for the field, also where
it is handed to a function of the same file.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.bounds import (
    LEAST,
    LENGTH,
    ROWS,
    bounds,
    lengths,
    lengths_read,
    refused_tests,
    turns_away,
    whole,
    within,
)
from tracerisk.instrument.source.literals.called_functions import (
    Function,
    calls_at,
    functions_imported,
    functions_of,
    parameter_name,
    source_tree,
)
from tracerisk.instrument.source.literals.comparisons import (
    Constant,
    NamedState,
    bare_value,
    beyond,
    compared,
    is_number,
)

_DEEPEST = 3  # of functions to which a value is handed on
_ANY_FIELD = frozenset({"data", "name", "id", "frame_id", "child_frame_id", "type"})
"""Fields that many messages have, each with another meaning."""
_THROUGH = frozenset({"enumerate", "list", "reversed", "sorted"})
_ARRAYS = frozenset({"array", "asarray", "list", "tuple"})
_RESHAPES = frozenset({"reshape", "flatten", "ravel", "copy", "astype"})
_INDEX = re.compile(r"\[(\d+)\]")
"""The last part of the path of an item of a list that is taken by its index."""
_OF_GOAL = frozenset({"request", "goal"})


@dataclass(frozen=True, slots=True)
class Compared:
    """The literals with which fields are compared."""

    values: Mapping[tuple[str, ...], tuple[Any, ...]] = field(default_factory=dict)
    """The literals in the order of the source, by path of the field; for `<` and `>` a number on
    the side on which the comparison holds."""

    def texts(self, path: tuple[str, ...]) -> tuple[str, ...]:
        """Return the texts with which a field is compared."""
        return tuple(text for text in self._of(path) if isinstance(text, str))

    def numbers(self, path: tuple[str, ...]) -> tuple[float, ...]:
        """Return the numbers with which a field is compared."""
        return tuple(number for number in self._of(path) if is_number(number))

    def length(self, path: tuple[str, ...]) -> int | None:
        """Return the length that the code asks of a list, in whole rows; None for none."""
        if asked := self.values.get((*path, LENGTH)):
            return int(asked[0])
        rows = {inner[:-1]: row[0] for inner, row in self.values.items() if ROWS in inner}
        row = int(rows.get(path, 1))
        return row * max(1, -(-self.least(path) // row)) if rows else None

    def least(self, path: tuple[str, ...]) -> int:
        """Return how long the code asks a list to be at least."""
        return max(self.values.get((*path, LEAST), ()), default=0)

    def by_index(self, path: tuple[str, ...]) -> dict[int, float]:
        """Return for items of a list one number each with which the code compares it."""
        numbers: dict[int, float] = {}
        for inner, values in self.values.items():
            number = next((value for value in values if is_number(value)), None)
            if inner[:-1] == path and (match := _INDEX.fullmatch(inner[-1])) and number is not None:
                numbers[int(match[1])] = number
        return numbers

    def truths(self, path: tuple[str, ...]) -> tuple[bool, ...]:
        """Return the truth values for each of which the code has a branch for a field."""
        return tuple(flag for flag in self._of(path) if isinstance(flag, bool))

    def is_known(self, path: tuple[str, ...]) -> bool:
        """Return whether the code compares a field with anything."""
        return bool(self._of(path))

    def state_of(self, path: tuple[str, ...]) -> str | None:
        """Return what is given a field as the name of one of its states; None for nothing."""
        states = (value for value in self._of(path) if isinstance(value, NamedState))
        return next((state.owner for state in states), None)

    def _of(self, path: tuple[str, ...]) -> tuple[Any, ...]:
        if path in self.values:
            return self.values[path]
        # A field that is compared after it was taken out of its message.
        return self.values.get(path[-1:], ())


def compared_in_callback(
    place: Location | None, argument: int = 0, constants: Mapping[str, Any] | None = None
) -> Compared:
    """Return the literals of the callback that a call at `place` names, else of the whole file.

    `argument` counts the callback's parameters behind `self`, `constants` are those of the message.
    """
    tree = source_tree(place)
    if tree is None or place is None:
        return Compared()
    functions = {**functions_imported(tree, Path(place.file)), **functions_of(tree)}
    calls = list(calls_at(tree, place.line))
    for call in (*calls, *_made_before(tree, calls)):
        for value in (*call.args, *(keyword.value for keyword in call.keywords)):
            # The callback itself, or within `partial(self.on, ...)`.
            for node in ast.walk(value):
                function: Function | None = functions.get(last_name(node))
                if isinstance(node, ast.Lambda):
                    function = node
                name = None if function is None else parameter_name(function, argument)
                if function is not None and name is not None:
                    flow = _flow(function, {name: ()}, functions, tree)
                    flow = {**_words_of_fields(tree, flow), **flow}
                    return Compared(_frozen(flow, constants))
    return Compared(_frozen(_by_field(tree), constants))


def _made_before(tree: ast.AST, calls: Iterable[ast.Call]) -> Iterator[ast.Call]:
    """Yield the calls that made what is started by one of `calls`: `server.start()`."""
    owners = {
        dotted_name(call.func.value) for call in calls if isinstance(call.func, ast.Attribute)
    }
    for node in ast.walk(tree):
        if not isinstance(node, ast.Assign) or not isinstance(node.value, ast.Call):
            continue
        if owners & {dotted_name(target) for target in node.targets} - {""}:
            yield node.value


def compared_in_file(place: Location | None) -> Compared:
    """Return the literals with which a file compares attributes, by their last name."""
    tree = source_tree(place)
    return Compared() if tree is None else Compared(_frozen(_by_field(tree)))


_Found = dict[tuple[str, ...], list[Any]]


def _frozen(
    found: _Found, constants: Mapping[str, Any] | None = None
) -> dict[tuple[str, ...], tuple[Any, ...]]:
    """Return what was found, each once; of constants the values, unless these are not known."""
    known = constants or {}
    frozen = {
        path: tuple(
            dict.fromkeys(
                known[value.name] if isinstance(value, Constant) else value
                for value in values
                if not isinstance(value, Constant) or value.name in known
            )
        )
        for path, values in found.items()
    }
    return {path: values for path, values in frozen.items() if values}


def _flow(
    function: Function,
    roots: Mapping[str, tuple[str, ...]],
    functions: Mapping[str, Function],
    tree: ast.AST,
    depth: int = 0,
) -> _Found:
    """Follow names that hold a message or a field of it through a function."""
    known = dict(roots)
    flow: _Found = {}
    kept: dict[str, tuple[str, ...]] = {}
    for node in ast.walk(function):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            path = _path(_made_of(node.value), known)
            if path is None:
                path = _read_out(node.value, known, functions)
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for name, is_kept in _given(targets) if path is not None else ():
                known[name] = path or ()
                if is_kept:
                    kept[name] = path or ()
        elif isinstance(node, ast.For | ast.comprehension):
            # What is in a list has the path of the list.
            item, path = _item(node.target, node.iter), _path(_listed(node.iter), known)
            if path is not None and item:
                known[item] = path
    _bound(function, known, flow)
    refused = set(_refused(function))
    for node in ast.walk(function):
        for listed, kind, length in lengths_read(node):
            path = _path(_made_of(listed), known)
            if path:
                flow.setdefault((*path, kind), []).append(length)
        if node not in refused:
            _compare(node, known, flow)
        if depth < _DEEPEST:
            _follow_call(node, known, function, functions, tree, depth, flow)
    for node in ast.walk(tree) if kept else ():
        _compare(node, kept, flow)
        if depth < _DEEPEST:
            _follow_call(node, kept, function, functions, tree, depth, flow)
    return flow


def _given(targets: Iterable[ast.expr]) -> Iterator[tuple[str, bool]]:
    """Yield the names that an assignment gives, and whether each is an attribute."""
    for target in targets:
        for part in target.elts if isinstance(target, ast.Tuple) else [target]:
            if dotted_name(part):
                yield dotted_name(part), isinstance(part, ast.Attribute)


def _follow_call(
    node: ast.AST,
    known: Mapping[str, tuple[str, ...]],
    function: Function,
    functions: Mapping[str, Function],
    tree: ast.AST,
    depth: int,
    found: _Found,
) -> None:
    """Add what a function that is called with known names compares them with."""
    callee = functions.get(last_name(node.func)) if isinstance(node, ast.Call) else None
    if not isinstance(node, ast.Call) or callee is None or callee is function:
        return
    given = {
        name: path
        for index, value in enumerate(node.args)
        if (path := _path(value, known)) is not None
        and (name := parameter_name(callee, index)) is not None
    }
    for path, values in _flow(callee, given, functions, tree, depth + 1).items() if given else ():
        found.setdefault(path, []).extend(values)


def _read_out(
    value: ast.expr, known: Mapping[str, tuple[str, ...]], functions: Mapping[str, Function]
) -> tuple[str, ...] | None:
    """Return the path of a text that a function of the controller turns into the assigned value."""
    if not isinstance(value, ast.Call) or last_name(value.func) not in functions:
        return None
    path = _path(value.args[0], known) if len(value.args) == 1 else None
    return path or None


def _refused(function: Function) -> Iterator[ast.AST]:
    """Yield the comparisons that hold for what a function refuses: `if mode == 9: return False`."""
    for node in ast.walk(function):
        if not isinstance(node, ast.If) or node.orelse:
            continue
        if turns_away(node.body):
            # For inequalities the bounds say on which side the code goes on.
            yield from (inner for inner in ast.walk(node.test) if _is_unequal(inner))
        if not _is_refusal(node.body):
            continue
        for inner in ast.walk(node.test):
            if isinstance(inner, ast.Compare) and isinstance(inner.ops[0], ast.Eq | ast.In):
                yield inner


def _is_unequal(node: ast.AST) -> bool:
    return isinstance(node, ast.Compare) and isinstance(
        node.ops[0], ast.Lt | ast.LtE | ast.Gt | ast.GtE
    )


def _is_refusal(body: list[ast.stmt]) -> bool:
    *others, last = body
    if not all(isinstance(other, ast.Expr) for other in others):
        return False
    value = last.value if isinstance(last, ast.Return) else None
    if isinstance(value, ast.Tuple) and value.elts:
        value = value.elts[0]
    return isinstance(last, ast.Raise) or (isinstance(value, ast.Constant) and value.value is False)


def _listed(iterated: ast.expr) -> ast.expr:
    """Return the list that a loop goes through: `messages` of `enumerate(messages)`."""
    if isinstance(iterated, ast.Call) and last_name(iterated.func) in _THROUGH and iterated.args:
        return iterated.args[0]
    return iterated


def _item(target: ast.expr, iterated: ast.expr) -> str:
    """Return the name that each item of a list is given in a loop; empty for none."""
    if isinstance(target, ast.Tuple) and _listed(iterated) is not iterated:
        target = target.elts[-1]
    return target.id if isinstance(target, ast.Name) else ""


def _compare(node: ast.AST, known: Mapping[str, tuple[str, ...]], found: _Found) -> None:
    for subject, value in compared(node):
        path = None if subject is None else _path(subject, known)
        if path:
            found.setdefault(path, []).append(value)
        item = None if subject is None else _item_path(subject, known)
        if item is not None:
            found.setdefault(item, []).append(value)


def _item_path(node: ast.expr, known: Mapping[str, tuple[str, ...]]) -> tuple[str, ...] | None:
    """Return the path of an item that is taken by its index: `msg.data[0]`; None for others."""
    bare = bare_value(node)
    if isinstance(bare, ast.Call) and last_name(bare.func) == "abs" and len(bare.args) == 1:
        bare = bare_value(bare.args[0])
    if not isinstance(bare, ast.Subscript) or (index := whole(bare.slice)) is None or index < 0:
        return None
    path = _path(_made_of(bare.value), known)
    return (*path, f"[{index}]") if path else None


def _bound(function: ast.AST, known: Mapping[str, tuple[str, ...]], found: _Found) -> None:
    """Add the middle of the bounds within which the code goes on, and the lengths of lists."""
    for test, is_refused in refused_tests(function):
        for subject, low, high in bounds(test, is_refused=is_refused):
            path, value = _path(subject, known), within(low, high)
            if value is None and is_refused:
                value = beyond(low, +1) if low is not None else beyond(high, -1)
            for item in (path, _item_path(subject, known)):
                if item and value is not None:
                    found.setdefault(item, []).append(value)
        for counted, kind, length in lengths(test, is_refused=is_refused):
            path = _path(_made_of(counted), known)
            if path is not None:
                found.setdefault((*path, kind), []).append(length)


def _made_of(node: ast.expr) -> ast.expr:
    """Return the list of which an array is made: `msg.data` of `np.asarray(msg.data).ravel()`."""
    while isinstance(node, ast.Call):
        if last_name(node.func) in _ARRAYS and node.args:
            node = node.args[0]
        elif isinstance(node.func, ast.Attribute) and node.func.attr in _RESHAPES:
            node = node.func.value
        else:
            break
    return node


def _words_of_fields(tree: ast.AST, but: _Found) -> _Found:
    """Return the words that the file compares with fields, except those that `but` knows."""
    known = {path[-1] for path in but}
    return {
        path: values
        for path, values in _by_field(tree).items()
        if path[-1] not in known | _ANY_FIELD and all(isinstance(value, str) for value in values)
    }


def _by_field(tree: ast.AST) -> _Found:
    """Return the literals by the last name of the attribute that is compared with them."""
    by_field: _Found = {}
    for node in ast.walk(tree):
        for subject, value in compared(node):
            bare = None if subject is None else bare_value(subject)
            if isinstance(bare, ast.Attribute):
                by_field.setdefault((bare.attr,), []).append(value)
    return by_field


def _path(node: ast.expr, known: Mapping[str, tuple[str, ...]]) -> tuple[str, ...] | None:
    """Return the path of the field that an expression is; None where it is none."""
    bare = bare_value(node)
    names: list[str] = []
    while True:
        dotted = dotted_name(bare)
        if dotted in known:
            rest = tuple(reversed(names))
            path = (*known[dotted], *rest)
            # The goal of a goal handle is the message.
            return path[1:] if path[:1] and path[0] in _OF_GOAL and len(path) > 1 else path
        if isinstance(bare, ast.Subscript):
            # What is in a list has the path of the list.
            bare = bare.value
            continue
        if not isinstance(bare, ast.Attribute):
            return None
        names.append(bare.attr)
        bare = bare.value
