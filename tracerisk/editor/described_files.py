"""What may stand at a place in a YAML file that a JSON Schema describes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, get_args

from tracerisk.editor.completion import Offer
from tracerisk.pipeline.start.schemas import schema_text

FileKind = Literal["hardware", "scenario", "driver"]

_KINDS: tuple[FileKind, ...] = get_args(FileKind)
_TOP_KEY = re.compile(r"([A-Za-z_][\w.\-]*)\s*:(?:\s|$)")
_KEY = re.compile(
    r"""(?P<quote>["']?)(?P<key>[^\s"'{}\[\],:#][^"'{}\[\],:#]*?)(?P=quote)\s*:(?:\s+|$)"""
)


def kind_of(lines: Sequence[str]) -> FileKind | None:
    """Return which of the files a text is, by the keys at its top; `None` for another one."""
    keys = {matched[1] for line in lines if (matched := _TOP_KEY.match(line)) is not None}
    best: tuple[int, FileKind] | None = None
    for kind in _KINDS:
        known = keys & set(schema_of(kind)["properties"])
        # What all descriptions begin with distinguishes nothing.
        score = len(known - {"robot", "source", "name"})
        if score and len(known) == len(keys) and (best is None or score > best[0]):
            best = score, kind
    return None if best is None else best[1]


@lru_cache(maxsize=len(_KINDS))
def schema_of(kind: FileKind) -> Any:
    """Return the JSON Schema of a kind of file."""
    return json.loads(schema_text(kind))


@dataclass(frozen=True, slots=True)
class _Cursor:
    """A place in a YAML text."""

    path: tuple[str, ...]
    """The keys and `-` that lead from the top to the place."""
    key: str | None
    """The key whose value is being typed; `None` where a key is being typed."""
    typed: str
    """The text typed so far of that key or value."""
    present: tuple[str, ...] = ()
    """The keys that the table around it has."""


def yaml_offers(kind: FileKind, lines: Sequence[str], line: int, before: str) -> Iterator[Offer]:
    """Yield what may stand at the end of `before`, the begin of a line, from 0, of a text."""
    if "#" in re.sub(r"""("[^"]*"|'[^']*')""", "", before):
        return
    cursor = _cursor(lines, line, before)
    root = schema_of(kind)
    nodes = _at(root, [root], cursor.path)
    if cursor.key is not None:
        nodes = _at(root, nodes, (cursor.key,))
        yield from _value_offers(nodes, cursor.typed)
        return
    seen = set(cursor.present)
    for node in nodes:
        for key, below in node.get("properties", {}).items():
            if key not in seen and key.startswith(cursor.typed):
                seen.add(key)
                about = _about(root, below)
                yield Offer(f"{key}: ", about, "key", cursor.typed)
    yield from _value_offers(nodes, cursor.typed)


def _value_offers(nodes: Sequence[Any], typed: str) -> Iterator[Offer]:
    seen = set()
    for node in nodes:
        values = [*node.get("enum", ()), *([node["const"]] if "const" in node else [])]
        if node.get("type") == "boolean":
            values += [True, False]
        for value in values:
            text = value if isinstance(value, str) else json.dumps(value)
            text = json.dumps(text) if text in ("*", "") else text
            if text not in seen and text.startswith(typed):
                seen.add(text)
                yield Offer(text, str(node.get("description", "")), "value", typed)


def _about(root: Any, node: Any) -> str:
    """Return what a schema says of a key."""
    if "description" in node:
        return str(node["description"])
    reported = [
        alternative["description"]
        for alternative in _alternatives(root, node)
        if "description" in alternative
    ]
    return reported[0] if reported else ""


def _at(root: Any, nodes: Sequence[Any], path: Sequence[str]) -> list[Any]:
    """Return the schemas of what stands at a path below any of several."""
    alternatives = [alternative for node in nodes for alternative in _alternatives(root, node)]
    for step in path:
        below: list[Any] = []
        for node in alternatives:
            if step == "-":
                below += [node["items"]] if isinstance(node.get("items"), dict) else []
            elif step in node.get("properties", {}):
                below.append(node["properties"][step])
            elif isinstance(node.get("additionalProperties"), dict):
                below.append(node["additionalProperties"])
        alternatives = [alternative for node in below for alternative in _alternatives(root, node)]
    return alternatives


def _alternatives(root: Any, node: Any) -> list[Any]:
    """Return a schema with those that it refers to or chooses from."""
    if not isinstance(node, dict):
        return []
    alternatives = [node]
    reference = node.get("$ref")
    if isinstance(reference, str):
        below = root
        for part in reference.removeprefix("#/").split("/"):
            below = below[part]
        alternatives += _alternatives(root, below)
    for several in ("anyOf", "oneOf", "allOf"):
        for item in node.get(several, ()):
            alternatives += _alternatives(root, item)
    return alternatives


def _cursor(lines: Sequence[str], line: int, before: str) -> _Cursor:
    """Return where the end of `before` is, by the indentation of the lines above."""
    indent, dashes, rest = _parts(before)
    flow, key, typed, present = _flow(rest)
    column = indent + 2 * len(dashes)
    above = _above(lines, line, indent, is_item=bool(dashes))
    path = [*above, *("-" for _ in dashes)]
    here = () if flow else _siblings(lines, line, column, is_item=bool(dashes))
    return _Cursor((*path, *flow), key, typed, (*present, *here))


def _parts(text: str) -> tuple[int, list[int], str]:
    """Return the indentation of a line, the columns of its dashes, and what stands behind."""
    at = len(text) - len(text.lstrip(" "))
    indent, dashes = at, []
    while text.startswith("-", at) and (at + 1 == len(text) or text[at + 1] == " "):
        dashes.append(at)
        at += 1
        at += len(text[at:]) - len(text[at:].lstrip(" "))
    return indent, dashes, text[at:]


def _above(lines: Sequence[str], line: int, indent: int, *, is_item: bool) -> list[str]:
    """Return the keys and dashes around a line, the outermost first."""
    path: list[str] = []
    for number in range(line - 1, -1, -1):
        text = lines[number]
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        own, dashes, rest = _parts(text)
        key = _KEY.match(rest)
        column = own if not dashes else dashes[-1] + 2
        # An item may stand as far left as the key of its list.
        if key is not None and (column < indent or (column == indent and is_item and not dashes)):
            path.insert(0, key["key"])
            indent, is_item = column, False
        for at in reversed(dashes):
            if at < indent:
                path.insert(0, "-")
                indent, is_item = at, True
        if indent == 0 and not is_item:
            break
    return path


def _siblings(lines: Sequence[str], line: int, column: int, *, is_item: bool) -> tuple[str, ...]:
    """Return the keys of the table around a line that begin at a column, but for its own.

    A line that begins an item has none above it.
    """
    siblings = []
    for step in (1,) if is_item else (-1, 1):
        number = line + step
        while 0 <= number < len(lines):
            text = lines[number]
            own, dashes, rest = _parts(text)
            number += step
            if not text.strip() or text.lstrip().startswith("#"):
                continue
            begins = own if not dashes else dashes[-1] + 2
            if own < column and (step > 0 or begins < column):
                break  # of the table around, or the next item
            key = _KEY.match(rest)
            if begins == column and key is not None:
                siblings.append(key["key"])
            if dashes and own < column and step < 0:
                break
    return tuple(siblings)


def _flow(text: str) -> tuple[tuple[str, ...], str | None, str, tuple[str, ...]]:
    """Return where the end of a line's text is: the path, the key, what is typed, other keys.

    So it is in tables and lists in braces as well.
    """
    path: list[str] = []
    key: str | None = None
    keys: list[str] = []
    around: list[tuple[int, str | None, list[str]]] = []
    at = 0
    while at < len(text):
        sign = text[at]
        matched = _KEY.match(text, at) if key is None else None
        if matched is not None:
            key, at = matched["key"], matched.end()
            keys.append(key)
        elif sign in "{[":
            around.append((len(path), key, keys))
            path += [] if key is None else [key]
            path += ["-"] if sign == "[" else []
            key, keys, at = None, [], at + 1
        elif sign in "}]" and around:
            length, key, keys = around.pop()
            del path[length:]
            at += 1
        elif sign == "," and around:
            key, at = None, at + 1
        elif sign == " ":
            at += 1
        else:
            end = _scalar_end(text, at, is_flow=bool(around))
            if end == len(text):
                return tuple(path), key, text[at:], tuple(keys)
            at = end
    return tuple(path), key, "", tuple(keys)


def _scalar_end(text: str, at: int, *, is_flow: bool) -> int:
    """Return where a scalar that begins at a place of a line ends."""
    if text[at] in "\"'":
        end = text.find(text[at], at + 1)
        return len(text) if end < 0 else end + 1
    if not is_flow:
        return len(text)
    return next((n for n in range(at, len(text)) if text[n] in "{}[],"), len(text))
