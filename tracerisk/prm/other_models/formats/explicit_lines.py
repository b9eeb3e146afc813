"""The lines and words of explicit files, with their places."""

from __future__ import annotations

import enum
import re
from collections.abc import Iterator

from tracerisk.common.text.bounded import whole_number
from tracerisk.errors import Location, ModelError

_PIECE = 1_000_000
"""How many characters of a text are split into lines at a time."""
LONG = 19
"""From so many digits on, a number is looked at by itself."""


class Dialect(enum.Enum):
    """Whose files."""

    STORM = "storm"
    PRISM = "prism"


def lines_of(text: str, start: int = 0) -> Iterator[tuple[int, list[tuple[int, str]]]]:
    """Yield the number of each line that is not blank, and its words with their columns.

    The first `start` lines are left out.
    """
    for number, line in numbered_lines(text):
        if number > start and line.strip():
            yield number, words_of(line)


def numbered_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines and their numbers; of a long text not all are held at once."""
    number = 0
    for piece in pieces(text):
        for line in piece.splitlines():
            number += 1
            yield number, line


def pieces(text: str) -> Iterator[str]:
    """Yield whole lines, about a million characters at a time."""
    begin = 0
    while begin < len(text):
        end = text.find("\n", begin + _PIECE) + 1 or len(text)
        yield text[begin:end]
        begin = end


def words_of(line: str) -> list[tuple[int, str]]:
    """Return the words of a line with their columns."""
    return [(match.start() + 1, match.group()) for match in re.finditer(r"\S+", line)]


def whole(word: tuple[int, str], file: str, line: int) -> int:
    """Return the whole number that a word is; raise ModelError with its place where it is none."""
    column, text = word
    if not text.isascii() or not text.isdigit():
        raise ModelError(
            f"'{text}' is not a whole number of 0 or more", Location(file, line, column)
        )
    try:
        return whole_number(text)
    except ValueError as error:
        raise ModelError(f"cannot read {error}", Location(file, line, column)) from error
