"""The functions and risk blocks of one version of a source, as far as it can be read."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from threading import Lock

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.function_ref import QualifiedName
from tracerisk.errors import BlockError, Location, TraceRiskError
from tracerisk.instrument.source.language import is_c

_KEPT = 64
_ONE_AT_A_TIME = Lock()
_MOST_PROBLEMS = 8
"""After so many malformed blocks the rest of a source is left unread."""
_GUTTER = re.compile(rb"([ \t\f]*)#[ \t]?\|.*?(\r?\n?)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Outline:
    """What a source holds; a malformed block is left out, and the others are kept."""

    functions: tuple[tuple[QualifiedName, int], ...] = ()
    """The qualified name of each function with the line of its `def`, from 1."""
    placed: tuple[PlacedBlock, ...] = ()
    """The risk blocks with their places."""
    problems: tuple[TraceRiskError, ...] = ()
    """Why a part of the source could not be read."""
    is_code_read: bool = True
    """Whether the source itself could be read: False while it is half typed."""

    def block_at(self, line: int) -> PlacedBlock | None:
        """Return the block on a line, from 1."""
        return next((b for b in self.placed if b.first_line <= line <= b.last_line), None)

    def at_lines_of(
        self, before: bytes, now: bytes, problems: tuple[TraceRiskError, ...]
    ) -> Outline:
        """Return the outline of `before` with the lines that its parts have in `now`.

        What stands where the two differ is left out.
        """
        old, new = before.splitlines(), now.splitlines()
        same = _common(old, new)
        below = _common(old[same:][::-1], new[same:][::-1])
        added, last = len(new) - len(old), len(old) - below

        def moved(line: int) -> int | None:
            if line <= same:
                return line
            return line + added if line > last else None

        def placed(block: PlacedBlock) -> PlacedBlock | None:
            places = [moved(each) for each in (block.line, block.first_line, block.last_line)]
            line, first, end = places
            if line is None or first is None or end is None:
                return None
            if end - first != block.last_line - block.first_line:
                return None
            return block._replace(
                block=_shifted(block, first - block.first_line),
                line=line,
                first_line=first,
                last_line=end,
            )

        functions = [(name, line) for name, at in self.functions if (line := moved(at)) is not None]
        blocks = [each for block in self.placed if (each := placed(block)) is not None]
        return Outline(tuple(functions), tuple(blocks), problems, is_code_read=False)


def _common(one: list[bytes], other: list[bytes]) -> int:
    """Return how many lines two lists have in common at their begin."""
    pairs = enumerate(zip(one, other, strict=False))
    return next((at for at, (a, b) in pairs if a != b), min(len(one), len(other)))


def _shifted(placed: PlacedBlock, by: int) -> RiskBlock:
    if not by:
        return placed.block

    def there(place: Location | None) -> Location | None:
        if place is None or place.line is None:
            return place
        return replace(place, line=place.line + by)

    def component(entry: ComponentEntry) -> ComponentEntry:
        return replace(entry, location=there(entry.location))

    block = placed.block
    return replace(
        block,
        location=there(block.location),
        components=tuple(map(component, block.components)),
    )


def outline_of(source: bytes, file: str) -> Outline:
    """Return the outline of a source; `file` is its name in messages.

    Raises nothing for what is malformed: see `Outline.problems`.
    """
    with _ONE_AT_A_TIME:  # who comes second finds it read
        return _outline_of(source, file)


@lru_cache(maxsize=_KEPT)
def _outline_of(source: bytes, file: str) -> Outline:
    problems: list[TraceRiskError] = []
    left = source
    while True:
        try:
            placed = follow_renames(left, file, ()).placed
            return Outline(tuple(functions_in(left, file)), placed, tuple(problems))
        except BlockError as error:
            problems.append(error)
            less = None if is_c(file) else _without_block(left, error.location)
            if less is None or len(problems) > _MOST_PROBLEMS:
                return Outline(problems=tuple(problems), is_code_read=False)
            left = less
        except TraceRiskError as error:
            return Outline(problems=(*problems, error), is_code_read=False)


def _without_block(source: bytes, place: Location | None) -> bytes | None:
    """Return the source with a malformed block made plain comment, on as many lines."""
    if place is None or place.line is None:
        return None
    lines = source.splitlines(keepends=True)
    at = first = last = place.line - 1
    if at >= len(lines) or not _GUTTER.fullmatch(lines[at]):
        return None
    while first > 0 and _GUTTER.fullmatch(lines[first - 1]):
        first -= 1
    while last + 1 < len(lines) and _GUTTER.fullmatch(lines[last + 1]):
        last += 1
    for number in range(first, last + 1):
        lines[number] = _GUTTER.sub(rb"\1#\2", lines[number], count=1)
    return b"".join(lines)
