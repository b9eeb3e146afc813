"""Literals that a source names once and then uses by name: `RED = 3`, `self.poses = {RED: 0.1}`."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from tracerisk.instrument.source.dotted_names import dotted_name


def literal_value(node: ast.expr) -> Any:
    """Return the value of an expression that is a literal; None for any other."""
    try:
        return ast.literal_eval(node)
    except (ValueError, TypeError, SyntaxError, RecursionError):
        return None


def with_named_literals(
    tree: ast.Module, settings: Callable[[], Mapping[str, ast.expr]] = dict
) -> ast.Module:
    """Return the tree with literals for names that it compares with or looks something up in.

    Only a name that is assigned exactly once is replaced: one that is assigned twice, incremented
    or a parameter stays. A mapping after `in` is replaced by its keys. `settings` returns literals
    by their keys in files of settings: they stand for `config["key"]` and `config.get("key")`.
    """
    return _Inlined(_named(tree), settings).visit(tree)  # type: ignore[no-any-return]


def _named(tree: ast.Module) -> dict[str, ast.expr]:
    """Return the literals, and the mappings with keys, by the one name that each is given."""
    given: Counter[str] = Counter()
    values: dict[str, ast.expr] = {}
    put: dict[str, list[ast.expr]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                values |= {dotted_name(name): value for name, value in _pairs(target, node.value)}
        if isinstance(node, ast.Name | ast.Attribute) and not isinstance(node.ctx, ast.Load):
            given[dotted_name(node)] += 1
        if isinstance(node, ast.arg):
            given[node.arg] += 1
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            put.setdefault(dotted_name(node.value), []).append(node.slice)
    for name, short, value in _in_classes(tree):
        if given[short] == 1:
            values |= {name: value, f"{name}.value": value, f"self.{short}": value}
            given[name] = given[f"{name}.value"] = 1
            given[f"self.{short}"] += 1
    named = {
        name: _with_keys(value, put.get(name, ()))
        for name, value in values.items()
        if name and given[name] == 1 and isinstance(value, _WHOLE)
    }
    return named | _looped(tree, named, given)


def _looped(
    tree: ast.Module, named: Mapping[str, ast.expr], given: Mapping[str, int]
) -> dict[str, ast.expr]:
    """Return the texts through which loops go, by the name that a loop gives each of them.

    `for word, pose in poses.items()` gives `word` the keys, and `pose` the texts of the values.
    """
    texts: dict[str, list[ast.expr]] = {}
    loops: Counter[str] = Counter()
    for node in ast.walk(tree):
        if not isinstance(node, ast.For | ast.comprehension):
            continue
        for target, items in _columns(node.target, node.iter, {**named, **_lists(texts)}):
            if isinstance(target, ast.Name):
                loops[target.id] += 1
                texts.setdefault(target.id, []).extend(items)
    return {name: value for name, value in _lists(texts).items() if given[name] == loops[name]}


def _lists(texts: Mapping[str, list[ast.expr]]) -> dict[str, ast.expr]:
    return {name: ast.List(items, ast.Load()) for name, items in texts.items() if items}


def _columns(
    target: ast.expr, iterated: ast.expr, known: Mapping[str, ast.expr]
) -> Iterator[tuple[ast.expr, list[ast.expr]]]:
    """Yield each target of a loop with the texts that it is given one after another."""
    method = ""
    if isinstance(iterated, ast.Call) and isinstance(iterated.func, ast.Attribute):
        method, iterated = iterated.func.attr, iterated.func.value
    whole = known.get(dotted_name(iterated), iterated)
    rows: list[tuple[ast.expr, ...]] = []
    if isinstance(whole, ast.Dict) and method in ("", "items", "keys"):
        pairs = [(k, v) for k, v in zip(whole.keys, whole.values, strict=True) if k is not None]
        rows = [pair if method == "items" else pair[:1] for pair in pairs]
    elif isinstance(whole, ast.List | ast.Tuple | ast.Set) and not method:
        is_row = isinstance(target, ast.Tuple)
        rows = [
            tuple(item.elts) if is_row and isinstance(item, ast.Tuple) else (item,)
            for item in whole.elts
        ]
    targets = target.elts if isinstance(target, ast.Tuple) else [target]
    for index, part in enumerate(targets):
        yield part, [text for row in rows if index < len(row) for text in _texts(row[index])]


def _texts(node: ast.expr) -> list[ast.expr]:
    """Return a text, or those of a list."""
    items = node.elts if isinstance(node, ast.List | ast.Tuple | ast.Set) else [node]
    return [
        item for item in items if isinstance(item, ast.Constant) and isinstance(item.value, str)
    ]


def _with_keys(value: ast.expr, keys: Iterable[ast.expr]) -> ast.expr:
    """Return a mapping with the literal keys, too, under which something is put into it later."""
    more = [key for key in keys if isinstance(key, ast.Constant | ast.Attribute)]
    if not isinstance(value, ast.Dict) or not more:
        return value
    return ast.Dict([*value.keys, *more], [*value.values, *(ast.Constant(None) for _ in more)])


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[ast.expr, ast.expr]]:
    """Return what is given what: `a, b = 1, 2` gives two names."""
    are_tuples = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
    if are_tuples and len(target.elts) == len(value.elts):  # type: ignore[attr-defined]
        return list(zip(target.elts, value.elts, strict=True))  # type: ignore[attr-defined]
    return [(target, value)]


_MOST_COUNTED = 64
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
        setting = self._named.get(dotted_name(node))
        if setting is None and (key := _setting(node)) is not None:
            setting = self._settings().get(key)
        return setting

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        node.left = self._value(node.left)
        node.comparators = [self._value(comparator) for comparator in node.comparators]
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
        elif isinstance(node.func, ast.Attribute) and node.func.attr == "index":
            node.func.value = self._value(node.func.value)
        elif isinstance(node.func, ast.Name) and node.func.id == "raw_input":
            node.func.id = "input"  # as Python 3 calls it
        return node

    def visit_match_case(self, node: ast.match_case) -> ast.AST:
        self.generic_visit(node)
        for item in ast.walk(node.pattern):
            if isinstance(item, ast.MatchValue):
                item.value = self._value(item.value)
        return node

    def _mapping(self, node: ast.expr) -> ast.expr:
        result = self._found(node)
        if not isinstance(result, ast.Dict):
            return node
        return ast.Dict(self._keys(result), result.values)

    def _keys(self, mapping: ast.Dict) -> list[ast.expr | None]:
        return [None if key is None else self._value(key) for key in mapping.keys]

    def _value(self, node: ast.expr) -> ast.expr:
        """Return the literal that a name in a comparison stands for; what is no name as it is."""
        named = node
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.args:
            named = node.func.value if node.func.attr == "keys" else node
        result = self._found(named) or node
        if isinstance(result, ast.Dict):
            parts = [e for e in self._keys(result) if isinstance(e, ast.Constant | ast.Attribute)]
            return ast.List(list(parts), ast.Load())
        if isinstance(result, ast.List | ast.Tuple | ast.Set):
            return ast.List([self._value(element) for element in result.elts], ast.Load())
        return result


def _setting(node: ast.expr) -> str | None:
    """Return the key of `config["key"]` and `config.get("key")`."""
    key: ast.expr | None = None
    if isinstance(node, ast.Subscript):
        key = node.slice
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
        key = node.args[0] if node.func.attr == "get" else None
    is_text = isinstance(key, ast.Constant) and isinstance(key.value, str)
    return key.value if is_text else None  # type: ignore[union-attr]


def counted_names(node: ast.AST) -> tuple[str, ...]:
    """Return the items of a comprehension over numbers: `[f"joint_{i}" for i in range(1, 7)]`.

    Empty for anything else, or if an item depends on more than the number and literal text.
    """
    if not isinstance(node, ast.ListComp | ast.GeneratorExp) or len(node.generators) != 1:
        return ()
    loop = node.generators[0]
    if loop.ifs or not isinstance(loop.target, ast.Name):
        return ()
    texts = [_text(node.elt, loop.target.id, number) for number in _counted(loop.iter)]
    return tuple(text for text in texts if text is not None)


def _counted(node: ast.expr) -> Sequence[int]:
    if isinstance(node, ast.Call) and dotted_name(node.func) == "range":
        bounds = [_number(argument, "", 0) for argument in node.args]
        if 1 <= len(bounds) <= 3 and None not in bounds and 0 not in bounds[2:]:
            return range(*(bound or 0 for bound in bounds))[:_MOST_COUNTED]
    if isinstance(node, ast.List | ast.Tuple):
        numbers = [_number(element, "", 0) for element in node.elts]
        return [number for number in numbers if number is not None]
    return ()


def _number(node: ast.expr, name: str, value: int) -> int | None:
    if isinstance(node, ast.Name):
        return value if node.id == name else None
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        left, right = _number(node.left, name, value), _number(node.right, name, value)
        if left is not None and right is not None:
            return left + right if isinstance(node.op, ast.Add) else left - right
    return None


def _text(node: ast.expr, name: str, value: int) -> str | None:
    """Return the text that an expression makes of a number, None for what is none."""
    parts: list[str | None] = [None]
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        parts = [node.value]
    elif isinstance(node, ast.JoinedStr):
        parts = [_text(item, name, value) for item in node.values]
    elif isinstance(node, ast.FormattedValue) and node.format_spec is None:
        parts = [_shown(node.value, name, value)]
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        parts = [_text(node.left, name, value), _text(node.right, name, value)]
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mod):
        parts = [_filled(node.left, ("%d", "%i", "%s"), _shown(node.right, name, value))]
    elif isinstance(node, ast.Call) and len(node.args) == 1:
        shown = _shown(node.args[0], name, value)
        if isinstance(node.func, ast.Attribute) and node.func.attr == "format":
            parts = [_filled(node.func.value, ("{}", "{0}"), shown)]
        elif dotted_name(node.func) == "str":
            parts = [shown]
    return None if None in parts else "".join(part or "" for part in parts)


def _shown(node: ast.expr, name: str, value: int) -> str | None:
    number = _number(node, name, value)
    return None if number is None else str(number)


def _filled(node: ast.expr, places: Iterable[str], shown: str | None) -> str | None:
    text = node.value if isinstance(node, ast.Constant) else None
    if isinstance(text, str) and shown is not None:
        for place in places:
            if text.count(place) == 1 and text.count(place[0]) == 1:
                return text.replace(place, shown)
    return None
