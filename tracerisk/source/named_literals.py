"""Literals that a source names once and then uses by name: `RED = 3`, `self.poses = {RED: 0.1}`."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator, Mapping

from tracerisk.source.dotted_names import dotted_name


def with_named_literals(
    tree: ast.Module, settings: Callable[[], Mapping[str, ast.expr]] = dict
) -> ast.Module:
    """Return the tree with literals where it compares with, or looks up in, a name given once.

    A name that is given twice, counted up or a parameter's keeps its place. Of a mapping that is
    compared with (`in`) stand its keys. `settings` returns literals by their keys in files of
    settings: they stand for `config["key"]` and `config.get("key")`.
    """
    return _Inlined(_named(tree), settings).visit(tree)  # type: ignore[no-any-return]


def _named(tree: ast.Module) -> dict[str, ast.expr]:
    """Return the literals, and the mappings with keys, by the one name that each is given."""
    given: Counter[str] = Counter()
    values: dict[str, ast.expr] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                values |= {dotted_name(name): value for name, value in _pairs(target, node.value)}
        if isinstance(node, ast.Name | ast.Attribute) and not isinstance(node.ctx, ast.Load):
            given[dotted_name(node)] += 1
        if isinstance(node, ast.arg):
            given[node.arg] += 1
    for name, short, value in _in_classes(tree):
        if given[short] == 1:
            values |= {name: value, f"{name}.value": value, f"self.{short}": value}
            given[name] = given[f"{name}.value"] = 1
            given[f"self.{short}"] += 1
    return {
        name: value
        for name, value in values.items()
        if name and given[name] == 1 and isinstance(value, _WHOLE)
    }


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[ast.expr, ast.expr]]:
    """Return what is given what: `a, b = 1, 2` gives two names."""
    are_tuples = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
    if are_tuples and len(target.elts) == len(value.elts):  # type: ignore[attr-defined]
        return list(zip(target.elts, value.elts, strict=True))  # type: ignore[attr-defined]
    return [(target, value)]


_WHOLE = (ast.Constant, ast.UnaryOp, ast.Dict, ast.List, ast.Tuple, ast.Set)


def _in_classes(tree: ast.Module) -> Iterator[tuple[str, str, ast.expr]]:
    for owner in ast.walk(tree):
        if not isinstance(owner, ast.ClassDef):
            continue
        for node in owner.body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                short = node.targets[0].id
                yield f"{owner.name}.{short}", short, node.value


class _Inlined(ast.NodeTransformer):
    def __init__(
        self, named: dict[str, ast.expr], settings: Callable[[], Mapping[str, ast.expr]]
    ) -> None:
        self._named = named
        self._settings = settings

    def _found(self, node: ast.expr) -> ast.expr | None:
        """Return the literal that a name or a setting stands for, None for what is neither."""
        found = self._named.get(dotted_name(node))
        if found is None and (key := _setting(node)) is not None:
            found = self._settings().get(key)
        return found

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        node.left = self._value(node.left)
        node.comparators = [self._value(each) for each in node.comparators]
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.ctx, ast.Load):
            node.value = self._mapping(node.value)
        return node

    def visit_Call(self, node: ast.Call) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.func, ast.Attribute) and node.func.attr == "get":
            node.func.value = self._mapping(node.func.value)
        return node

    def visit_match_case(self, node: ast.match_case) -> ast.AST:
        self.generic_visit(node)
        for each in ast.walk(node.pattern):
            if isinstance(each, ast.MatchValue):
                each.value = self._value(each.value)
        return node

    def _mapping(self, node: ast.expr) -> ast.expr:
        found = self._found(node)
        if not isinstance(found, ast.Dict):
            return node
        return ast.Dict(self._keys(found), found.values)

    def _keys(self, mapping: ast.Dict) -> list[ast.expr | None]:
        return [None if each is None else self._value(each) for each in mapping.keys]

    def _value(self, node: ast.expr) -> ast.expr:
        """Return the literal that a name in a comparison stands for; what is no name as it is."""
        named = node
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.args:
            named = node.func.value if node.func.attr == "keys" else node
        found = self._found(named) or node
        if isinstance(found, ast.Dict):
            parts = [each for each in self._keys(found) if isinstance(each, ast.Constant)]
            return ast.List(list(parts), ast.Load())
        if isinstance(found, ast.List | ast.Tuple | ast.Set):
            return ast.List([self._value(each) for each in found.elts], ast.Load())
        return found


def _setting(node: ast.expr) -> str | None:
    """Return the key of `config["key"]` and `config.get("key")`."""
    key: ast.expr | None = None
    if isinstance(node, ast.Subscript):
        key = node.slice
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
        key = node.args[0] if node.func.attr == "get" else None
    is_text = isinstance(key, ast.Constant) and isinstance(key.value, str)
    return key.value if is_text else None  # type: ignore[union-attr]
