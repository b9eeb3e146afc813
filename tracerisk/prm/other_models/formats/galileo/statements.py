"""The words and statements of Galileo text, with their positions."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.errors import Location, ModelError

_TOKEN = re.compile(
    r"""
    (?P<space>\s+|//[^\n]*|/\*.*?\*/)
  | "(?P<quoted>[^"\n]*)"
  | (?P<mark>[;=])
  | (?P<word>(?:pand|por)<=?(?=\s)|[^\s";=/]+(?:/(?![/*])[^\s";=/]*)*)
    """,
    re.VERBOSE | re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class Word:
    """A word, a name in quotes or a mark."""

    text: str
    """The characters, without quotes."""
    place: Location
    """Where it begins."""
    quoted: bool = False
    """Whether it stands in quotes."""

    @property
    def is_equals(self) -> bool:
        """Whether this is the mark between an attribute and its value."""
        return self.text == "=" and not self.quoted


@dataclass(frozen=True, slots=True)
class Statement:
    """What stands before one semicolon."""

    words: tuple[Word, ...]
    """Words that belong to no attribute, in order."""
    attributes: tuple[tuple[Word, Word], ...]
    """Attributes ((name, value), ...), in order."""


def read_statements(text: str, file: str) -> Iterator[Statement]:
    """Yield the statements of a text; `file` is its name in messages.

    Raises ModelError, with the position, at a quote or comment that does not end, a statement
    without its semicolon, or an equals sign without a name and a value.
    """
    gathered: list[Word] = []
    for word in _words(text, file):
        if word.text == ";" and not word.quoted:
            if gathered:
                yield _statement(gathered)
            gathered = []
        else:
            gathered.append(word)
    if gathered:
        raise ModelError(
            f"the statement that begins with '{gathered[0].text}' has no closing semicolon; is "
            "the file truncated?",
            gathered[0].place,
        )


def _words(text: str, file: str) -> Iterator[Word]:
    position, line, start_of_line = 0, 1, 0
    while position < len(text):
        place = Location(file, line, position - start_of_line + 1)
        matched = _TOKEN.match(text, position)
        if matched is None:
            what = "comment" if text.startswith("/*", position) else "name in quotes"
            if text[position] not in '"/':
                what = "word"
            raise ModelError(f"unterminated {what}", place)
        if matched["quoted"] is not None:
            yield Word(matched["quoted"], place, quoted=True)
        elif matched["space"] is None:
            yield Word(matched[0], place)
        line += matched[0].count("\n")
        if "\n" in matched[0]:
            start_of_line = position + matched[0].rindex("\n") + 1
        position = matched.end()


def _statement(gathered: list[Word]) -> Statement:
    words: list[Word] = []
    attributes: list[tuple[Word, Word]] = []
    position = 0
    while position < len(gathered):
        word = gathered[position]
        if word.is_equals:
            raise ModelError("an equals sign needs a name before it", word.place)
        if position + 1 < len(gathered) and gathered[position + 1].is_equals:
            if position + 2 >= len(gathered) or gathered[position + 2].is_equals:
                raise ModelError(f"'{word.text}=' needs a value after it", word.place)
            attributes.append((word, gathered[position + 2]))
            position += 3
        else:
            words.append(word)
            position += 1
    return Statement(tuple(words), tuple(attributes))
