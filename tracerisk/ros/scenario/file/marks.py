"""Which entries of a scenario nobody has confirmed: those with a comment `# assumed`.

`tracerisk scenario --write` sets the mark, and says behind it where the value is from. Whoever
deletes it says that the entry is so in their cell.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import Location

MARK = "# assumed"
"""What the comment of an unconfirmed line begins with."""

_MARK = re.compile(r"(?:^|(?<=\s))#\s*assumed\b\s*:?\s*(?P<words>.*?)\s*$")
_NAMES = ("topic", "name", "service", "action", "frame", "driver", "module")


@dataclass(frozen=True, slots=True)
class Unconfirmed:
    """An entry of a scenario with the mark."""

    section: str
    """The section of the scenario that it is in."""
    name: str
    """The name by which the entry is known: `/add`, `answers[1]`."""
    words: str
    """The text behind the mark, such as the origin of the value."""
    location: Location
    """The line with the mark."""
    first_line: int
    """The first line of the entry, from 1."""
    end_line: int
    """The line after its last, from 1; `sys.maxsize` for the last entry."""

    @property
    def what(self) -> str:
        """The entry in words: `services /add`, `answers[1]`."""
        return self.name if self.name.startswith(self.section) else f"{self.section} {self.name}"

    def holds(self, place: Location) -> bool:
        """Return whether a place of the scenario is within the entry."""
        return self.first_line <= (place.line or 0) < self.end_line


def unconfirmed(path: Path, top: YamlMap) -> tuple[Unconfirmed, ...]:
    """Return the entries of a scenario that have the mark, each once, in the file's order."""
    text = file_bytes(path).decode("utf-8-sig")
    marks = tuple(_marks(text))
    if not marks:
        return ()
    places = sorted(_places(top))
    unconfirmed: dict[tuple[str, str], Unconfirmed] = {}
    for line, words in marks:
        before = [row for row in places if row[0] <= line]
        if before:
            first, section, name = before[-1]
            place = Location(str(path), line)
            end = next((row[0] for row in places if row[0] > line), sys.maxsize)
            entry = Unconfirmed(section, name, words, place, first, end)
            unconfirmed.setdefault((section, name), entry)
    return tuple(unconfirmed.values())


def _marks(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and words of each mark; what stands within a text is none."""
    lines = text.splitlines()
    candidates = [
        (number, match) for number, line in enumerate(lines) for match in [_MARK.search(line)]
        if match is not None
    ]  # fmt: skip
    if not candidates:
        return
    spans = tuple(_spans(text))
    for number, match in candidates:
        at = number, match.start()
        if not any(start <= at < end for start, end in spans):
            yield number + 1, match["words"]


_Span = tuple[tuple[int, int], tuple[int, int]]


def _spans(text: str) -> Iterator[_Span]:
    """Yield where each quoted or block text of a YAML file begins and ends, from 0."""
    from ruamel.yaml import YAML
    from ruamel.yaml.tokens import ScalarToken

    for token in YAML(typ="safe", pure=True).scan(text):
        if isinstance(token, ScalarToken) and not token.plain:
            start, end = token.start_mark, token.end_mark
            yield (start.line, start.column), (end.line, end.column)


def _places(top: YamlMap) -> Iterator[tuple[int, str, str]]:
    """Yield line, section and name of each entry, and of each section itself."""
    for section in top.keys():  # noqa: SIM118 - no mapping of Python's
        value = top.get(section)
        yield top.key_location(section).line or 0, section, section
        if isinstance(value, dict):
            inner = top.map(section)
            for key in inner.keys():  # noqa: SIM118
                yield inner.key_location(key).line or 0, section, key
        elif isinstance(value, list):
            for index, entry in enumerate(value):
                line = top.entry_location(section, index).line or 0
                yield line, section, _name(entry, section, index)


def _name(entry: object, section: str, index: int) -> str:
    if isinstance(entry, dict):
        for key in _NAMES:
            if isinstance(entry.get(key), str):
                return str(entry[key])
    return entry_name(section, index)


def entry_name(section: str, index: int) -> str:
    """Return what an entry is called that has no name of its own; `index` counts from 0."""
    return f"{section}[{index + 1}]"
