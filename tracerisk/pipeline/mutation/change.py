"""A change of a controller at one place: a range of a file's bytes, and what it becomes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from tracerisk.adder.sources.edits import Edit, apply_edits
from tracerisk.errors import InputError, Location

ChangeKind = Literal[
    "unit",
    "sign",
    "scale",
    "slot",
    "name",
    "call-dropped",
    "call-doubled",
    "calls-swapped",
    "wait-dropped",
    "result-dropped",
    "loop-shortened",
    "condition-turned",
]
"""What is changed: docs/mutation.md."""
KINDS: tuple[ChangeKind, ...] = get_args(ChangeKind)
_LONGEST = 48


@dataclass(frozen=True, slots=True)
class Change:
    """A change of one of a controller's files, made on its original bytes."""

    file: str
    """The file, from the controller's root."""
    start: int
    """Where the changed bytes begin in the file."""
    end: int
    """Where they end."""
    old: bytes
    """What is there."""
    new: bytes
    """What takes its place."""
    kind: ChangeKind
    """What kind of change it is."""
    line: int
    """The line at which it begins, from 1."""
    function: str
    """The qualified name of the function that is changed."""
    words: str
    """The change in one line."""

    def applied(self, source: bytes) -> bytes:
        """Return the file with the change made.

        Raises InputError where the file has something else at the place.
        """
        if source[self.start : self.end] != self.old:
            raise InputError(
                "was changed by someone else meanwhile; run the same command again",
                Location(self.file, self.line),
            )
        return apply_edits(source, [Edit(self.start, self.end, self.new)])


@dataclass(frozen=True, slots=True)
class Draft:
    """A change of the text that libcst reads, whose bytes are in UTF-8."""

    start: int
    """Where the changed bytes begin."""
    end: int
    """Where they end."""
    new: str
    """What takes their place."""
    kind: ChangeKind
    """What kind of change it is."""
    words: str
    """The change in one line."""


def brief(code: str) -> str:
    """Return code on one line, shortened where it is long."""
    line = " ".join(code.split())
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST - 3]}..."
