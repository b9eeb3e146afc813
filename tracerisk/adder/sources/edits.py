"""A source edit is a range of bytes and its new text, made on the original bytes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tracerisk.adder.sources.python_lines import BYTE_ORDER_MARK, PythonSource


@dataclass(frozen=True, slots=True)
class Edit:
    """A replacement of some bytes of a source."""

    start: int
    """The first byte to replace."""
    end: int
    """The byte after the last one to replace; `start` for an insertion."""
    text: bytes
    """The new bytes."""


def apply_edits(source: bytes, edits: Iterable[Edit]) -> bytes:
    """Return `source` with all edits made.

    Raises:
        ValueError: if two edits overlap.
    """
    parts, at = [], 0
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.end)):
        if edit.start < at:
            raise ValueError("edits overlap")
        parts += [source[at : edit.start], edit.text]
        at = edit.end
    return b"".join([*parts, source[at:]])


def line_starts(source: PythonSource) -> tuple[int, ...]:
    """Return where each line starts, and where the last one ends; a BOM is before line 1."""
    starts, at = [], 0
    for line in source.lines:
        starts.append(at)
        at += len(line)
    starts.append(at)
    if source.lines and source.lines[0].startswith(BYTE_ORDER_MARK):
        starts[0] = len(BYTE_ORDER_MARK)
    return tuple(starts)
