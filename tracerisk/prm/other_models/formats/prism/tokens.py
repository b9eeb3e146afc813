"""The words of the PRISM language, with their positions."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NoReturn

from tracerisk.errors import Location, ModelError

_WORD = re.compile(
    r"""(?P<space>\s+|//[^\n]*)
    |(?P<number>\d+\.\d+(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+|\d+)
    |(?P<name>[A-Za-z_][A-Za-z0-9_]*)
    |(?P<text>"[^"\n]*")
    |(?P<sign><=>|->|\.\.|<=|>=|!=|=>|[-=<>&|!+*/()\[\]{}:;,'?])""",
    re.VERBOSE,
)


@dataclass(frozen=True, slots=True)
class Token:
    """A word of the text."""

    kind: str
    """`number`, `name`, `text` (in quotes), `sign` or `end`."""
    text: str
    """The characters, quotes included; "" for the end."""
    location: Location
    """Where it begins."""

    def refuse(self, expected: str) -> NoReturn:
        """Raise ModelError: something else was expected here."""
        text = f"'{self.text}'" if self.kind != "end" else "the end of the file"
        raise ModelError(f"expected {expected}, found {text}", self.location)


def tokens_of(text: str, file: str) -> list[Token]:
    """Return the words of a text, then an end; raise ModelError where there is no word."""
    tokens: list[Token] = []
    position, line, line_start = 0, 1, 0
    while position < len(text):
        location = Location(file, line, position - line_start + 1)
        # Two dots part a range; one before digits belongs to a number.
        match = _WORD.match(text, position)
        if text.startswith("..", position):
            tokens.append(Token("sign", "..", location))
            position += 2
            continue
        if match is None:
            raise ModelError(f"{text[position]!r} is not part of the PRISM language", location)
        kind = str(match.lastgroup)
        if kind != "space":
            tokens.append(Token(kind, match.group(), location))
        else:
            breaks = match.group().count("\n")
            if breaks:
                line += breaks
                line_start = match.start() + match.group().rindex("\n") + 1
        position = match.end()
    tokens.append(Token("end", "", Location(file, line, position - line_start + 1)))
    return tokens
