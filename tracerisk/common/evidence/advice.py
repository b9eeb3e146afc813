"""What would help: the places in a controller where a check would show undetected failures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tracerisk.common.evidence.cells import Cell, MissedCheck
from tracerisk.errors import Location

_WORDS: dict[MissedCheck, str] = {
    "result": "the answer to this call is not looked at",
    "grip": "the width of the gripper is not read in time after this command, or not acted upon",
    "time_limit": "this wait has no time limit",
}


@dataclass(frozen=True, slots=True)
class Advice:
    """A check that is missing at a place, and what it would show."""

    check: MissedCheck
    """What is not looked at."""
    location: Location
    """The place, in the controller's file."""
    cells: tuple[Cell, ...]
    """The undetected failures that it would show; at least one."""

    @property
    def words(self) -> str:
        """What is missing and what that leaves undetected, in a sentence."""
        kinds = dict.fromkeys(
            f"{cell.component} {cell.mode.replace('_', ' ')}" for cell in self.cells
        )
        number = len(self.cells)
        failures = "1 failure ends" if number == 1 else f"{number} failures end"
        return f"{_WORDS[self.check]}: {failures} the mission undetected ({', '.join(kinds)})"


def advice_of(cells: Iterable[Cell]) -> tuple[Advice, ...]:
    """Return the places where a check would help, those with the most failures first."""
    places: dict[tuple[str, MissedCheck], list[Cell]] = {}
    for cell in cells:
        if cell.is_undetected and cell.missed_check is not None:
            places.setdefault((cell.missed_at, cell.missed_check), []).append(cell)
    ordered = sorted(places.items(), key=lambda item: (-len(item[1]), item[0]))
    return tuple(Advice(check, _location(at), tuple(own)) for (at, check), own in ordered)


def _location(at: str) -> Location:
    file, _, line = at.rpartition(":")
    return Location(file, int(line)) if file and line.isdigit() else Location(at)
