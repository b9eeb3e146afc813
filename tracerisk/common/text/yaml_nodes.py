"""YAML as maps and lists that know the place of every key and entry, read by libyaml.

What a file of thousands of entries is read with: some ten times as fast as `ruamel.yaml`, which
keeps comments too. Scalars are those of the core schema of YAML 1.2: `1e-7` is a number, `yes`
and a date are strings.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from yaml import YAMLError, events
from yaml.cyaml import CParser
from yaml.error import MarkedYAMLError
from yaml.reader import ReaderError

_MAX_DEPTH = 100
_TOO_DEEP = f"is nested deeper than {_MAX_DEPTH} levels"
_CORE = "tag:yaml.org,2002:"
_MERGE = "<<"
_WORDS: Mapping[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_FIRST_OF_NUMBERS = frozenset("+-.0123456789")

Position = tuple[int, int]
"""Line and column, from 0."""


class PlacedYamlError(ValueError):
    """A mistake in the YAML, with where it stands, from 0."""

    def __init__(self, message: str, position: Position | None) -> None:
        super().__init__(message)
        self.message = message
        self.position = position


class Places:
    """Where a map or a list begins, and where each key or entry of it stands, from 0."""

    __slots__ = ("col", "data", "line")

    def __init__(self, start: Position) -> None:
        self.line, self.col = start
        self.data: dict[Any, Position] = {}

    def key(self, key: str) -> Position:
        """Return where a key stands."""
        return self.data[key]

    def item(self, index: int) -> Position:
        """Return where an entry stands."""
        return self.data[index]


class PlacedMap(dict[Any, Any]):
    """A map with the places of its keys; those that were merged in have none."""

    __slots__ = ("lc",)

    def __init__(self, start: Position) -> None:
        super().__init__()
        self.lc = Places(start)


class PlacedList(list[Any]):
    """A list with the places of its entries."""

    __slots__ = ("lc",)

    def __init__(self, start: Position) -> None:
        super().__init__()
        self.lc = Places(start)


def load_placed(text: str) -> Any:
    """Return the one document of a text.

    Raises PlacedYamlError where it is not YAML, holds a key twice, a value of a type of its own,
    an anchor that holds itself, or is nested deeper than 100 levels.
    """
    try:
        return _Document(CParser(text)).load()
    except MarkedYAMLError as cause:
        marks = [mark for mark in (cause.problem_mark, cause.context_mark) if mark is not None]
        # A text that ends in the midst has its end for a place, or the begin of what lacks one.
        last = text.count("\n")
        within = [(mark.line, mark.column) for mark in marks if mark.line <= last]
        end = (last, len(text) - text.rfind("\n") - 1)
        words = [word for word in (cause.context, cause.problem) if word]
        if cause.problem == "exceeded maximum nesting depth":
            # From libyaml 0.2.6 on its scanner, which reads ahead, ends before the events do.
            words = [_TOO_DEEP]
        raise PlacedYamlError(", ".join(words), within[0] if within else end) from cause
    except ReaderError as cause:
        raise PlacedYamlError(str(cause.reason), None) from cause
    except YAMLError as cause:
        raise PlacedYamlError(str(cause), None) from cause


class _Document:
    """Builds the values of one document from the events of the parser."""

    def __init__(self, parser: CParser) -> None:
        self._next: Callable[[], Any] = parser.get_event
        self._anchors: dict[str, Any] = {}
        self._depth = 0

    def load(self) -> Any:
        self._next()  # the start of the stream
        event = self._next()
        if isinstance(event, events.StreamEndEvent):
            return None
        value = self._value(self._next())
        self._next()  # the end of the document
        event = self._next()
        if not isinstance(event, events.StreamEndEvent):
            raise PlacedYamlError("holds a second document; give one", _start(event))
        return value

    def _value(self, event: Any) -> Any:
        if isinstance(event, events.ScalarEvent):
            value = _scalar(event)
            if event.anchor is not None:
                self._anchors[event.anchor] = value
            return value
        if isinstance(event, events.AliasEvent):
            if event.anchor not in self._anchors:
                message = f"unknown anchor '*{event.anchor}'"
                raise PlacedYamlError(message, _start(event))
            return self._anchors[event.anchor]
        if event.tag not in (None, "!", f"{_CORE}map", f"{_CORE}seq"):
            raise PlacedYamlError(f"unknown type {event.tag}", _start(event))
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise PlacedYamlError(_TOO_DEEP, _start(event))
        is_map = isinstance(event, events.MappingStartEvent)
        built = self._map(event) if is_map else self._list(event)
        self._depth -= 1
        # Only now: an alias within would hold itself, and is reported as one of no anchor.
        if event.anchor is not None:
            self._anchors[event.anchor] = built
        return built

    def _map(self, event: Any) -> PlacedMap:
        result = PlacedMap(_start(event))
        merged: list[PlacedMap] = []
        while not isinstance(key_event := self._next(), events.MappingEndEvent):
            position = _start(key_event)
            if not isinstance(key_event, events.ScalarEvent):
                raise PlacedYamlError("a key is not a string", position)
            if key_event.value == _MERGE and key_event.implicit[0]:
                merged += _merged(self._value(self._next()), position)
                continue
            key = self._value(key_event)
            if key in result:
                raise PlacedYamlError(f"holds the key '{key}' twice", position)
            result[key] = self._value(self._next())
            result.lc.data[key] = position
        for placed_map in merged:
            for key, value in placed_map.items():
                result.setdefault(key, value)
        return result

    def _list(self, event: Any) -> PlacedList:
        placed_list = PlacedList(_start(event))
        while not isinstance(entry := self._next(), events.SequenceEndEvent):
            placed_list.lc.data[len(placed_list)] = _start(entry)
            placed_list.append(self._value(entry))
        return placed_list


def _start(event: Any) -> Position:
    return event.start_mark.line, event.start_mark.column


def _merged(value: Any, position: Position) -> list[PlacedMap]:
    maps = value if isinstance(value, PlacedList) else [value]
    if not all(isinstance(item, PlacedMap) for item in maps):
        raise PlacedYamlError("'<<' must refer to a mapping", position)
    return list(maps)


def _scalar(event: Any) -> Any:
    """Return the value of a scalar, by the core schema of YAML 1.2."""
    text: str = event.value
    if event.tag not in (None, "!"):
        return _typed(text, event)
    if not event.implicit[0]:
        return text
    if text in _WORDS:
        return _WORDS[text]
    return _number(text) if text[0] in _FIRST_OF_NUMBERS else text


def _number(text: str) -> Any:
    """Return a number, or the text where it is none."""
    if _INTEGER.fullmatch(text):
        # A whole number of so many digits is above all floats, and slow to read.
        return float(text) if len(text) > 400 else int(text, 0 if text[1:2] in "ox" else 10)
    if _FLOAT.fullmatch(text):
        return float(text)
    return float(text.replace(".", "", 1)) if _INFINITE.fullmatch(text) else text


def _typed(text: str, event: Any) -> Any:
    if event.tag == f"{_CORE}str":
        return text
    value = _WORDS[text] if text in _WORDS else _number(text) if text else None
    kinds = {"null": type(None), "bool": bool, "int": int, "float": float}
    kind = kinds.get(event.tag.removeprefix(_CORE))
    if kind is None:
        raise PlacedYamlError(f"unknown type {event.tag}", _start(event))
    if kind is float and type(value) is int:
        return float(value)
    if type(value) is not kind:
        raise PlacedYamlError(f"'{text}' is not of the type {event.tag}", _start(event))
    return value
