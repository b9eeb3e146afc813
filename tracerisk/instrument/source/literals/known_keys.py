"""Which keys of a keyboard a source knows."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.answers import ordered_answers
from tracerisk.instrument.source.literals.called_functions import source_tree

_ESCAPE = "\x1b"
_LONGEST_CODE = 6


def known_keys(place: Location | None) -> tuple[str, ...]:
    """Return the keys that the source at `place` compares with or looks up, as it names them.

    What ends the program comes last.
    """
    tree = source_tree(place)
    if tree is None:
        return ()
    rows = sorted(
        (node.lineno, node.col_offset, place_in_text, key)
        for item in ast.walk(tree)
        for node, keys in _keys_of(item)
        for place_in_text, key in enumerate(keys)
        if _is_key(key)
    )
    return ordered_answers(key for *_, key in rows)


def _keys_of(node: ast.AST) -> Iterator[tuple[ast.expr, tuple[str, ...]]]:
    """Yield the texts that a node compares with or looks up, each with its place."""
    if isinstance(node, ast.Compare):
        for operator, side in zip(node.ops, node.comparators, strict=True):
            if isinstance(operator, ast.In | ast.NotIn):
                yield from _members(side)
            elif isinstance(operator, ast.Eq | ast.NotEq):
                yield from _texts((node.left, side))
    elif isinstance(node, ast.MatchValue):
        yield from _texts((node.value,))
    elif isinstance(node, ast.Dict):
        keys = [key for key in node.keys if key is not None]
        texts = list(_texts(keys))
        if len(texts) == len(node.keys) and all(_is_key(text) for _, (text,) in texts):
            yield from texts


def _members(side: ast.expr) -> Iterator[tuple[ast.expr, tuple[str, ...]]]:
    if isinstance(side, ast.Tuple | ast.List | ast.Set):
        yield from _texts(side.elts)
    for node, (text,) in _texts((side,)):
        yield node, tuple(text)


def _texts(nodes: Iterable[ast.expr]) -> Iterator[tuple[ast.expr, tuple[str, ...]]]:
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node, (node.value,)


def _is_key(text: str) -> bool:
    """Whether a text is one character, or the code of an arrow or the like."""
    return len(text) == 1 or (text.startswith(_ESCAPE) and len(text) <= _LONGEST_CODE)
