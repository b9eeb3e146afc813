"""Rests that are elsewhere in a later run: how far and in which direction, many in one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from tracerisk.common.outcome.arm import Position, angle_between
from tracerisk.common.outcome.outcome import Rest
from tracerisk.common.outcome.result_changes import (
    ends_elsewhere,
    millimetres,
    position_words,
)
from tracerisk.common.outcome.tolerances import ROUNDING, Tolerances

_UPRIGHT = 0.999  # what part of a shift is along z that is called higher or lower


@dataclass(frozen=True, slots=True)
class MovedRest:
    """A rest of the earlier run, and the one of the later run that takes its place."""

    number: int
    """The rest's place among those of its arm in the earlier run, from 1 on."""
    total: int
    """How many rests of the arm the earlier run has; 0 where not all were kept."""
    old: Rest
    """The earlier rest."""
    new: Rest
    """The later rest."""
    tolerances: Tolerances
    """By how much two rests may differ that are the same."""

    @property
    def words(self) -> str:
        """Which rest it is, and where it is now."""
        return f"{rest_name(self.number, self.total, self.old)} is now {self._now}"

    @property
    def _now(self) -> str:
        if not self.is_shifted:
            return f"with the tool turned by {self._turned_deg:.0f} deg"
        aside = (
            f"{millimetres(math.hypot(*self.shift_m))} from there, at "
            f"{position_words(self.new.tool_m)}"
        )
        return _up_or_down(self.shift_m) or aside

    @property
    def end_words(self) -> str:
        """Where the arm ends, if it is the last rest of both runs."""
        if self.is_shifted:
            return ends_elsewhere(self.old.tool_m, self.new.tool_m)
        return f"ends with the tool turned by {self._turned_deg:.0f} deg from where it ended"

    @property
    def shift_m(self) -> Position:
        """From where the tool rested to where it rests [m]."""
        x, y, z = (now - was for was, now in zip(self.old.tool_m, self.new.tool_m, strict=True))
        return x, y, z

    @property
    def is_shifted(self) -> bool:
        """Whether the tool is at another place; else it is turned."""
        return math.hypot(*self.shift_m) > self.tolerances.place_m * ROUNDING

    @property
    def _turned_deg(self) -> float:
        return math.degrees(angle_between(self.old.tool_turn, self.new.tool_turn))

    def is_as(self, other: MovedRest) -> bool:
        """Return whether another rest of the same arm is shifted by as much in its direction."""
        if self.old.arm != other.old.arm or not (self.is_shifted and other.is_shifted):
            return False
        return math.dist(self.shift_m, other.shift_m) <= self.tolerances.place_m * ROUNDING


def rest_name(number: int, total: int, rest: Rest) -> str:
    """Return which rest it is; `total` is 0 where not all of its arm were kept."""
    of = f" of {total}" if total else ""
    return f"rest {number}{of} at {position_words(rest.tool_m)}"


def moved_together(rests: Sequence[MovedRest]) -> dict[str, str]:
    """Return for the words of each rest the sentence of all rests that are shifted as it is."""
    sentences: dict[str, str] = {}
    left = list(rests)
    while left:
        alike = [left[0], *(rest for rest in left[1:] if rest.is_as(left[0]))]
        sentence = _sentence(alike) if len(alike) > 1 else left[0].words
        sentences.update({rest.words: sentence for rest in alike})
        left = [rest for rest in left if rest not in alike]
    return sentences


def _sentence(alike: Sequence[MovedRest]) -> str:
    shift = alike[0].shift_m
    total = alike[0].total
    of = f" of {total}" if total else ""
    by = ", ".join(f"{1000.0 * value + 0.0:.0f}" for value in shift)
    now = _up_or_down(shift) or f"{millimetres(math.hypot(*shift))} away, by ({by}) mm"
    numbers = _numbers(sorted(rest.number for rest in alike))
    first = position_words(min(alike, key=lambda rest: rest.number).old.tool_m)
    return f"{len(alike)} rests{of} are now {now}: {numbers}, the first at {first}"


def _up_or_down(shift: Position) -> str:
    """Return by how much a shift goes up or down; empty where it goes aside."""
    length = math.hypot(*shift)
    if abs(shift[2]) < _UPRIGHT * length:
        return ""
    return f"{millimetres(length)} {'higher' if shift[2] > 0.0 else 'lower'}"


def _numbers(numbers: Sequence[int]) -> str:
    """Return numbers in words, three and more in a row as `4 to 7`."""
    return ", ".join(_rows(numbers))


def _rows(numbers: Sequence[int]) -> Iterator[str]:
    ends = [i + 1 for i, (one, then) in enumerate(pairwise(numbers)) if then != one + 1]
    for begin, end in pairwise([0, *ends, len(numbers)]):
        row = numbers[begin:end]
        if len(row) > 2:
            yield f"{row[0]} to {row[-1]}"
        else:
            yield from map(str, row)
