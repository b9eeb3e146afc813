"""Which keys of a keyboard a source knows."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator

from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.literals.answers import ordered_answers
from tracerisk.instrument.source.literals.called_functions import source_tree
from tracerisk.instrument.source.literals.key_codes import CODES, code_of_name

_ESCAPE = "\x1b"
_LONGEST_CODE = 6
_OF_KEYS = re.compile(
    r"(^|[._])(c|ch|chr|char|k|key|keycode|key_code|inp|cmd|command|getch|getkey|get_key|get_wch"
    r"|getKey|waitKey|read_key|(key|event|e)\.name)$"
)
_OF_LIBRARIES = re.compile(r"(^|[._])(curses|[kK]ey|pygame)$")
_PRESSED = re.compile(
    r"(^|\.)(is_pressed|add_hotkey|on_(press|release)_key)$|(^|\.)keyboard\.wait$"
)  # of `keyboard`
_PRINTED = range(32, 127)


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
    """Yield the keys that a node compares with or looks up, each with its place."""
    if isinstance(node, ast.Compare):
        is_key = any(_OF_KEYS.search(_asked(side)) for side in (node.left, *node.comparators))
        for operator, side in zip(node.ops, node.comparators, strict=True):
            if isinstance(operator, ast.In | ast.NotIn):
                yield from _members(side, is_key=is_key)
            elif isinstance(operator, ast.Eq | ast.NotEq | ast.Is | ast.IsNot):
                yield from _keys((node.left, side), is_key=is_key)
    elif isinstance(node, ast.MatchValue):
        yield from _keys((node.value,), is_key=False)
    elif isinstance(node, ast.Call) and _PRESSED.search(_asked(node)):
        yield from _keys(node.args[:1], is_key=True)
    elif isinstance(node, ast.Subscript):
        # `pygame.key.get_pressed()[pygame.K_w]`
        yield from _keys((node.slice,), is_key=False, is_named=True)
    elif isinstance(node, ast.Dict):
        keys = [key for key in node.keys if key is not None]
        known = list(_keys(keys, is_key=False))
        if len(known) == len(node.keys) and all(_is_key(text) for _, (text,) in known):
            yield from known


def _asked(node: ast.expr) -> str:
    """Return the name of a value, or of the function that returns it."""
    while isinstance(node, ast.Call):
        inner = node.func
        if isinstance(inner, ast.Attribute) and inner.attr in ("lower", "upper", "strip", "decode"):
            inner = inner.value
        node = inner
    return dotted_name(node) or last_name(node)


def _members(side: ast.expr, *, is_key: bool) -> Iterator[tuple[ast.expr, tuple[str, ...]]]:
    if isinstance(side, ast.Tuple | ast.List | ast.Set):
        yield from _keys(side.elts, is_key=is_key)
    for node, (text,) in _keys((side,), is_key=False):
        yield node, tuple(text)


def _keys(
    nodes: Iterable[ast.expr], *, is_key: bool, is_named: bool = False
) -> Iterator[tuple[ast.expr, tuple[str, ...]]]:
    """Yield the keys that expressions stand for: texts, `ord('w')`, names of libraries.

    With `is_key` they are compared with a key: then a number is its code, and a word its name.
    With `is_named` the names of libraries alone are keys.
    """
    for node in nodes:
        key = _named(node) if is_named else _key(node, is_key=is_key)
        if key is not None:
            yield node, (key,)


def _key(node: ast.expr, *, is_key: bool) -> str | None:
    if isinstance(node, ast.Constant):
        if isinstance(node.value, str):
            return CODES.get(node.value, node.value) if is_key else node.value
        if is_key and type(node.value) is int and node.value > 0:
            code = chr(node.value) if node.value in _PRINTED else ""
            return code or next((c for c in CODES.values() if [*map(ord, c)] == [node.value]), None)
        return None
    if isinstance(node, ast.Call) and last_name(node.func) in ("ord", "from_char", "KeyCode"):
        given = [*node.args, *(keyword.value for keyword in node.keywords)]
        return _key(given[0], is_key=False) if len(given) == 1 else None
    return _named(node)


def _named(node: ast.expr) -> str | None:
    """Return the key that a name of a library stands for: `curses.KEY_UP`, `Key.up`."""
    name = dotted_name(node) or ""
    owner, _, last = name.rpartition(".")
    is_library = _OF_LIBRARIES.search(owner) is not None
    if is_library or last.startswith(("KEY_", "K_")):
        return code_of_name(last)
    return None


def _is_key(text: str) -> bool:
    """Return whether a text is one character, or the code of an arrow or the like."""
    return len(text) == 1 or (text.startswith(_ESCAPE) and len(text) <= _LONGEST_CODE)
