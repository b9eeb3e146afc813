"""What the run of a controller in another world showed, beside the run itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from tracerisk.common.worlds.world import WORLDS
from tracerisk.errors import Location

WORLDS_KEPT = "worlds"
"""The key of a lock's summary under which the worlds of a run are kept."""


@dataclass(frozen=True, slots=True)
class WorldRun:
    """A run in another world, and how it differs from the run itself."""

    world: str
    """The name of the world: docs/worlds.md."""
    verdict: str
    """The kind of its verdict; empty where it had none."""
    reason: str = ""
    """The first reason of its verdict that the run itself does not have, in words."""
    differs: tuple[str, ...] = ()
    """What it brought about that is different, a sentence each, the gravest first."""
    cause: str = ""
    """What is known of why: what was sent to an end that was not connected yet, or what was read of
    joint states that come in another order."""
    location: Location | None = None
    """The file, from the controller's root, and the line that it depends on, where known."""

    @property
    def depends(self) -> bool:
        """Whether verdict or outcome depend on the world."""
        return bool(self.reason or self.differs)

    @property
    def words(self) -> str:
        """What depends on the world, in one sentence; empty where nothing does."""
        differ = self.differs[0] if self.differs else f"{self.verdict}: {self.reason}"
        return differ if self.depends else ""

    @property
    def changed(self) -> str:
        """What is different in the world, in words; empty for a name that is no longer there."""
        return next((world.description for world in WORLDS if world.name == self.world), "")

    def with_line(self, line_of: Callable[[str, int], int]) -> WorldRun:
        """Return it with another line; `line_of` takes a file and a line of it."""
        place = self.location
        if place is None or place.line is None:
            return self
        return replace(self, location=Location(place.file, line_of(place.file, place.line)))


def depending(runs: Iterable[WorldRun]) -> tuple[WorldRun, ...]:
    """Return the runs in worlds that verdict or outcome depend on."""
    return tuple(run for run in runs if run.depends)


def dependence_line(run: WorldRun) -> str:
    """Return in one sentence what depends on a world, and where that is known the line."""
    place = run.location
    at = "" if place is None else f" ({Location(place.file, place.line)})"
    what = f" ({run.changed})" if run.changed else ""
    why = f"; {run.cause}" if run.cause else ""
    return f"depends on world {run.world}{what}: {run.words}{why}{at}"


def joined_worlds(before: Iterable[WorldRun], now: Iterable[WorldRun]) -> tuple[WorldRun, ...]:
    """Return the runs of now, and those before in other worlds, by name of the world."""
    world_runs = {run.world: run for run in (*before, *now)}
    return tuple(run for _, run in sorted(world_runs.items()))


def worlds_summary(runs: Iterable[WorldRun]) -> dict[str, Any]:
    """Return what the lock keeps of runs in worlds: what depends on each; nothing without any."""
    kept: dict[str, Any] = {}
    for run in runs:
        entry: dict[str, Any] = {"verdict": run.verdict}
        if run.depends:
            entry["depends"] = run.words
        if run.cause:
            entry["cause"] = run.cause
        if run.depends and run.location is not None:
            entry["place"] = [run.location.file, run.location.line]
        kept[run.world] = entry
    return {WORLDS_KEPT: kept} if kept else {}


def kept_worlds(summary: Mapping[str, Any]) -> tuple[WorldRun, ...]:
    """Return the runs in worlds that a lock keeps, by name; what is malformed is left out."""
    data = summary.get(WORLDS_KEPT)
    world_runs = []
    for name, entry in sorted(data.items()) if isinstance(data, dict) else ():
        match entry:
            case {"verdict": str(verdict), **more}:
                words, cause = (more.get(key, "") for key in ("depends", "cause"))
                match more.get("place"):
                    case [str(file), int() | None as line]:
                        place: Location | None = Location(file, line)
                    case _:
                        place = None
                if isinstance(words, str) and isinstance(cause, str):
                    differs = (words,) if words else ()
                    world_runs.append(WorldRun(name, verdict, "", differs, cause, place))
    return tuple(world_runs)
