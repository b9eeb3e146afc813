"""Lines and columns of a text as an editor counts them.

A line ends with a line feed, a carriage return, or both: no other character that Python's
`splitlines` takes for an end. A column counts units of the encoding that the editor asked for.
"""

from __future__ import annotations

import re

from lsprotocol.types import Position, Range

_END = re.compile(r"\r\n|\n|\r")
_BYTES_A_UNIT = {"utf-8": 1, "utf-16": 2, "utf-32": 4}


class Lines:
    """The lines of a text, without their ends, and what gives places in them.

    `encoding` is that of the editor's columns.
    """

    def __init__(self, text: str, encoding: str = "utf-16") -> None:
        self.texts = tuple(_END.split(text))
        self._codec = encoding if encoding == "utf-8" else f"{encoding}-le"
        self._size = _BYTES_A_UNIT[encoding]

    def text(self, line: int) -> str:
        """Return a line, from 0 on; empty behind the last."""
        return self.texts[line] if 0 <= line < len(self.texts) else ""

    def units(self, text: str) -> int:
        """Return how many units of a column a text takes."""
        if text.isascii():
            return len(text)
        return len(text.encode(self._codec, "surrogatepass")) // self._size

    def index(self, position: Position) -> int:
        """Return the place of a position within its line, in characters; at most at its end."""
        text = self.text(position.line)
        if text.isascii():
            return min(int(position.character), len(text))
        left = int(position.character)
        for at, character in enumerate(text):
            if left <= 0:
                return at
            left -= self.units(character)
        return len(text)

    def position(self, line: int, index: int) -> Position:
        """Return the position of a character of a line, both from 0 on, kept within the text."""
        line = min(max(line, 0), len(self.texts) - 1)
        return Position(line, self.units(self.text(line)[: max(index, 0)]))

    def span(self, line: int, start: int, end: int) -> Range:
        """Return the range of characters from `start` up to `end` of a line."""
        return Range(self.position(line, start), self.position(line, end))

    def whole(self, first: int, last: int | None = None) -> Range:
        """Return the range of what stands on lines `first` to `last`, without the indentation."""
        first = min(max(first, 0), len(self.texts) - 1)
        last = first if last is None else min(max(last, first), len(self.texts) - 1)
        text = self.text(first)
        start = len(text) - len(text.lstrip())
        return Range(self.position(first, start), self.position(last, len(self.text(last))))
