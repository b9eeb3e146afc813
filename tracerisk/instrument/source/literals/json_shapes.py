"""What a source looks up in the JSON of a text that it is given: keys, items, known values.

Names are followed through the whole file without regard to the order of its lines: an attribute
by its name, a plain name within its function.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.called_functions import (
    calls_at,
    functions_of,
    parameter_name,
    source_tree,
)
from tracerisk.instrument.source.literals.comparisons import comparisons
from tracerisk.instrument.source.literals.named_literals import literal_value

_PASSES = 3  # over the file: a name may be read above the line that gives it
_SAME = frozenset({"lower", "upper", "strip", "title", "copy"})
_CASTS = frozenset({"float", "int", "str", "list", "tuple", "enumerate", "reversed", "sorted"})
_TAKES = frozenset({"pop", "popleft", "get", "get_nowait"})
_PUTS = frozenset({"append", "appendleft", "put", "put_nowait"})


@dataclass(slots=True)
class JsonShape:
    """A value of JSON, as far as the source shows what it is."""

    keys: dict[str, JsonShape] = field(default_factory=dict)
    """What is looked up in it by text, in the order of the source."""
    item: JsonShape | None = None
    """What it holds, where it is a list."""
    values: list[Any] = field(default_factory=list)
    """The literals with which it is compared."""
    defaults: list[Any] = field(default_factory=list)
    """The literals that stand for it where it is not given."""
    is_number: bool = False
    """Whether the source makes a number of it."""

    def key(self, name: str) -> JsonShape:
        """Return what is looked up under a name."""
        return self.keys.setdefault(name, JsonShape())

    def one(self) -> JsonShape:
        """Return the shape of a list's items."""
        if self.item is None:
            self.item = JsonShape()
        return self.item


def json_shape(place: Location | None) -> JsonShape | None:
    """Return what the callback named by a call at `place` reads of JSON; None for nothing."""
    tree = source_tree(place)
    if tree is None or place is None:
        return None
    functions = functions_of(tree)
    for call in calls_at(tree, place.line):
        for value in (*call.args, *(keyword.value for keyword in call.keywords)):
            callback = functions.get(last_name(value))
            message = None if callback is None else parameter_name(callback, 0)
            if callback is not None and message is not None:
                return _Reading(tree, functions).of(callback)
    return None


_Function = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda


class _Reading:
    def __init__(self, tree: ast.Module, functions: Mapping[str, _Function]) -> None:
        self._functions = functions
        self._owners: dict[ast.AST, ast.AST] = {}
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
                # An inner function comes later and owns its own lines.
                self._owners |= dict.fromkeys(ast.walk(function), function)
        self._nodes = list(ast.walk(tree))
        self._shapes: dict[tuple[ast.AST | None, str], JsonShape] = {}
        self._loads: dict[ast.AST, JsonShape] = {}

    def of(self, callback: _Function) -> JsonShape | None:
        """Return the shape of the JSON that a callback, or a function that it calls, reads."""
        called = {last_name(item.func) for item in ast.walk(callback) if isinstance(item, ast.Call)}
        within = (callback, *(f for name, f in self._functions.items() if name in called))
        loaded = [
            node
            for function in within
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and last_name(node.func) == "loads" and node.args
        ]
        if not loaded:
            return None
        root = JsonShape()
        self._loads = dict.fromkeys(loaded, root)
        for _ in range(_PASSES):
            for node in self._nodes:
                self._read(node)
        for node in self._nodes:
            for subject, value in comparisons(node):
                shape = None if subject is None else self._shape(subject)
                if shape is not None and not isinstance(value, bool):
                    # `"x" in data` asks for a key if `data` is something whose keys are looked up.
                    is_key = bool(shape.keys) and isinstance(value, str)
                    shape.key(value) if is_key else shape.values.append(value)
        return root

    def _read(self, node: ast.AST) -> None:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            shape = self._shape(node.value)
            for target in targets if shape is not None else ():
                self._give(target, shape)
        elif isinstance(node, ast.For | ast.comprehension):
            listed, target = self._shape(node.iter), node.target
            if listed is not None:
                is_counted = isinstance(node.iter, ast.Call) and isinstance(target, ast.Tuple)
                self._give(target.elts[-1] if is_counted else target, listed.one())  # type: ignore[attr-defined]
        elif isinstance(node, ast.Call):
            self._hand_on(node)
            self._shape(node)
        elif isinstance(node, ast.Subscript):
            self._shape(node)

    def _hand_on(self, call: ast.Call) -> None:
        given = [self._shape(argument) for argument in call.args]
        if isinstance(call.func, ast.Attribute) and call.func.attr in _PUTS and given[:1] != [None]:
            place = self._place(call.func.value)
            if place is not None and given:
                self._shapes.setdefault(place, JsonShape()).item = given[0]
        callee = self._functions.get(last_name(call.func))
        for index, shape in enumerate(given if callee is not None else ()):
            name = None if callee is None else parameter_name(callee, index)
            if shape is not None and name is not None:
                self._shapes[callee, name] = shape

    def _give(self, target: ast.expr, shape: JsonShape | None) -> None:
        if shape is None:
            return
        if isinstance(target, ast.Tuple):
            for part in target.elts:
                self._give(part, shape.one())
            return
        place = self._place(target)
        if place is not None:
            self._shapes[place] = shape

    def _place(self, node: ast.expr) -> tuple[ast.AST | None, str] | None:
        if isinstance(node, ast.Attribute):
            return None, f".{node.attr}"
        return (self._owners.get(node), node.id) if isinstance(node, ast.Name) else None

    def _shape(self, node: ast.expr) -> JsonShape | None:
        if node in self._loads:
            return self._loads[node]
        if isinstance(node, ast.Name | ast.Attribute):
            place = self._place(node)
            return None if place is None else self._shapes.get(place)
        if isinstance(node, ast.BoolOp):
            shapes = map(self._shape, node.values)
            return next((shape for shape in shapes if shape is not None), None)
        if isinstance(node, ast.IfExp):
            return self._shape(node.body) or self._shape(node.orelse)
        if isinstance(node, ast.Subscript):
            owner = self._shape(node.value)
            return None if owner is None else self._part(owner, node.slice)
        return self._called(node) if isinstance(node, ast.Call) else None

    def _called(self, call: ast.Call) -> JsonShape | None:
        name = last_name(call.func)
        if name in _CASTS and call.args:
            shape = self._shape(call.args[0])
            if shape is not None and name in ("float", "int"):
                shape.is_number = True
            return shape
        owner = self._shape(call.func.value) if isinstance(call.func, ast.Attribute) else None
        if owner is None:
            return None
        if name == "get" and call.args:
            shape = self._part(owner, call.args[0])
            shape.defaults += [item for item in map(_literal, call.args[1:2]) if item is not None]
            return shape
        if name in _TAKES:
            return owner.one()
        return owner if name in _SAME else None

    def _part(self, owner: JsonShape, index: ast.expr) -> JsonShape:
        key = _literal(index)
        return owner.key(key) if isinstance(key, str) else owner.one()


def _literal(node: ast.expr) -> Any:
    value = literal_value(node)
    return value if isinstance(value, bool | int | float | str | list) else None
