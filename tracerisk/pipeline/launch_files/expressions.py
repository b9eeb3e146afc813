"""Evaluate the small Python expressions of launch files: arithmetic, comparisons, texts."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

_LONGEST = 10_000
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
_COMPARED: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda one, two: one in two,
    ast.NotIn: lambda one, two: one not in two,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "bool": bool,
    "float": float,
    "int": int,
    "len": len,
    "max": max,
    "min": min,
    "round": round,
    "str": str,
}
_METHODS = frozenset(
    {"endswith", "lower", "lstrip", "replace", "rstrip", "split", "startswith", "strip", "upper"}
)
_NAMES = {"true": True, "false": False, "math": math, "pi": math.pi}


def evaluate(text: str, names: Mapping[str, Any]) -> Any:
    """Return the value of an expression over `names` and `math`.

    Raises ValueError with the reason when it holds anything but operators, texts, numbers, the
    usual functions and methods of texts, or fails.
    """
    if len(text) > _LONGEST:
        raise ValueError(f"an expression has more than {_LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return _Evaluation(names).of(tree.body)
    except (
        SyntaxError,
        TypeError,
        ArithmeticError,
        AttributeError,
        LookupError,
        RecursionError,
    ) as error:
        raise ValueError(f"'{text}' cannot be evaluated: {error}") from error


class _Evaluation:
    def __init__(self, names: Mapping[str, Any]) -> None:
        self._names = names

    def of(self, node: ast.expr) -> Any:
        match node:
            case ast.Constant():
                return node.value
            case ast.List() | ast.Tuple():
                return [self.of(elt) for elt in node.elts]
            case ast.Name():
                return self._name(node.id)
            case ast.BoolOp():
                return self._bool(node)
            case ast.UnaryOp() if type(node.op) in _UNARY:
                return _UNARY[type(node.op)](self.of(node.operand))
            case ast.BinOp() if type(node.op) in _BINARY:
                return self._binary(node)
            case ast.Compare():
                return self._compare(node)
            case ast.IfExp():
                return self.of(node.body if self.of(node.test) else node.orelse)
            case ast.Subscript():
                return self._item(node)
            case ast.Attribute(value=ast.Name(id="math")) if not node.attr.startswith("_"):
                return getattr(math, node.attr)
            case ast.Call():
                return self._call(node)
        raise ValueError(f"'{ast.unparse(node)}' is not a simple expression")

    def _name(self, name: str) -> Any:
        if name in self._names:
            return self._names[name]
        if name in _NAMES:
            return _NAMES[name]
        if hasattr(math, name) and not name.startswith("_"):
            return getattr(math, name)
        raise ValueError(f"nothing is called '{name}'")

    def _bool(self, node: ast.BoolOp) -> Any:
        value: Any = None
        for item in node.values:
            value = self.of(item)
            if bool(value) is isinstance(node.op, ast.Or):
                return value
        return value

    def _binary(self, node: ast.BinOp) -> Any:
        left, right = self.of(node.left), self.of(node.right)
        if isinstance(node.op, ast.Pow) and _size(left) * abs(right) > _LONGEST:
            raise ValueError("a power is too large")
        if isinstance(node.op, ast.Mult) and _length(left, right) > _LONGEST:
            raise ValueError(f"a text grows over {_LONGEST} characters")
        return _BINARY[type(node.op)](left, right)

    def _compare(self, node: ast.Compare) -> bool:
        left = self.of(node.left)
        for kind, comparator in zip(node.ops, node.comparators, strict=True):
            right = self.of(comparator)
            if not _COMPARED[type(kind)](left, right):
                return False
            left = right
        return True

    def _item(self, node: ast.Subscript) -> Any:
        if isinstance(node.slice, ast.Slice):
            bounds = (node.slice.lower, node.slice.upper, node.slice.step)
            return self.of(node.value)[slice(*(b and self.of(b) for b in bounds))]
        return self.of(node.value)[self.of(node.slice)]

    def _call(self, node: ast.Call) -> Any:
        arguments = [self.of(argument) for argument in node.args]
        if isinstance(node.func, ast.Name) and callable(self._names.get(node.func.id)):
            return self._names[node.func.id](*arguments)
        if isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
            return _FUNCTIONS[node.func.id](*arguments)
        if isinstance(node.func, ast.Attribute):
            if isinstance(node.func.value, ast.Name) and node.func.value.id == "math":
                return self.of(node.func)(*arguments)
            owner = self.of(node.func.value)
            if isinstance(owner, str) and node.func.attr in _METHODS:
                return getattr(owner, node.func.attr)(*arguments)
        elif isinstance(node.func, ast.Name):
            function = self._name(node.func.id)
            if callable(function):
                return function(*arguments)
        raise ValueError(f"'{ast.unparse(node.func)}' is not called here")


def _size(number: Any) -> int:
    """Return how many bits a number has."""
    return abs(number).bit_length() if isinstance(number, int) else 1


def _length(left: Any, right: Any) -> int:
    """Return how long a text or a list gets by being repeated; 0 where neither is one."""
    for series, times in ((left, right), (right, left)):
        if isinstance(series, str | list) and isinstance(times, int):
            return len(series) * times
    return 0
