"""What speaks for each robot that a controller may drive, and the one that follows from it.

Each thing that speaks has points, and the robot with the most is taken. Points are own figures:
the joints that a program lists say more than a name, its own words more than those of a library,
an exact name more than what lies about in the project.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

SURE = 20.0
"""Points from which a robot is taken without an assumption."""
LEAST = 3.0
"""Points from which a robot is taken at all: an assumption, but better than a generic arm."""
CLEAR = 30.0
"""A lead that is not put to the test by what has fewer points than it."""
_MOST_SAID = 4
_APART = 1.0  # points that decide between two

JOINTS = 100.0
"""For a robot with all joints that a source lists, and no other; against one with none of them."""
JOINTS_OF_ANY = 2.0
"""For joints whose names many arms have: `joint1`."""
PLACES = 30.0
"""For links, groups and controllers that a source names."""
LAUNCHED: Mapping[str, float] = {"controller": 60.0, "package": 20.0, "named": 12.0}
"""For the description that a launch file names, by whose launch file it is."""
DESCRIBED = 45.0
"""For a description of the workspace of which the controller names a part."""
NEAR = 12.0
"""For a description in the controller's own package, or one that it names."""
ONLY = 25.0
"""For the only robot of the workspace."""
DRIVER = 10.0
"""For what the driver is for whose messages are imported."""
NAMES: Mapping[str, float] = {
    "its imports": 50.0,
    "its import from modules of robots": 60.0,
    "its source": 40.0,
    "the SRDF": 35.0,
    "a module of its own": 25.0,
    "a library that it imports": 22.0,
    "a module of its package": 12.0,
    "what its package depends on": 25.0,
    "its file's name": 22.0,
    "its folder's name": 20.0,
    "its comments or docstrings": 15.0,
    "a command of a readme": 12.0,
    "a module's comments or docstrings": 10.0,
    "a program beside it": 8.0,
    "the package's manifest": 6.0,
    "a launch file": 5.0,
    "a parameter file": 4.0,
    "a readme": 3.0,
}
"""For the exact name of a robot, by where it is; several names in one text share them."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """One thing that speaks for a robot, or against it."""

    robot: str
    """A shipped robot by its name, one of the workspace by its file."""
    words: str
    """What speaks, as a sentence."""
    file: str
    """Where it is; empty for what has no place."""
    line: int | None
    """Its line, from 1; `None` where a whole file speaks."""
    points: float
    """How strongly it speaks; below 0 against the robot."""
    kind: Literal["joints", "parts", "name", "description", "driver"] = "description"
    """What is named, or what else speaks."""

    @property
    def place(self) -> str:
        """The file with the line."""
        return self.file if self.line is None else f"{self.file}:{self.line}"

    def __str__(self) -> str:
        where = f" ({self.place})" if self.file else ""
        return f"{self.points:+.1f} for {self.robot}: {self.words}{where}"


@dataclass(frozen=True, slots=True)
class Ranking:
    """The robots by the sum of what speaks for them."""

    best: str
    """The robot for which most speaks; empty where too little speaks for any."""
    points: float
    """The points of that robot."""
    rivals: tuple[str, ...]
    """The robots for which as much speaks, sorted."""

    @property
    def is_sure(self) -> bool:
        """Whether the robot needs no assumption."""
        return bool(self.best) and not self.rivals and self.points >= SURE


def ranked(evidence: Iterable[Evidence], preferred: Sequence[str] = ()) -> Ranking:
    """Return the robot for which most speaks.

    Of robots with equal points that one is taken which comes first in `preferred`, then by name.
    Where little speaks, and as much for several, it is none of them.
    """
    points = _sums(evidence)
    most = max(points.values(), default=0.0)
    if most < LEAST:
        return Ranking("", most, ())
    equal = [name for name, sum_ in points.items() if sum_ > most - _APART]
    if len(equal) > 1 and most < SURE:
        return Ranking("", most, tuple(sorted(equal)))
    order = {name: index for index, name in enumerate(preferred)}
    best, *rivals = sorted(equal, key=lambda name: (order.get(name, len(order)), name))
    return Ranking(best, points[best], tuple(sorted(rivals)))


def _sums(evidence: Iterable[Evidence]) -> dict[str, float]:
    """Return the points of each robot for which, or against which, anything speaks."""
    points: dict[str, float] = {}
    for one in evidence:
        points[one.robot] = points.get(one.robot, 0.0) + one.points
    return points


def shown(evidence: Iterable[Evidence]) -> tuple[Evidence, ...]:
    """Return what speaks for robots, the strongest first, and against those for which any does."""
    evidences = tuple(evidence)
    spoken = {one.robot for one in evidences if one.points >= LEAST}
    kept = (one for one in evidences if one.robot in spoken)
    return tuple(sorted(kept, key=lambda one: (-one.points, one.robot, one.words)))


def weighed(evidence: Iterable[Evidence], best: str, reason: str) -> str:
    """Return in one line what speaks for a robot beside the reason that is given for it.

    With it stands how many points it has, and the next ones; empty where there is neither. Without
    lines of sources: they change with the blocks that a run writes.
    """
    evidences = tuple(evidence)
    points = _sums(evidences)
    own = sorted((one for one in evidences if one.robot == best), key=lambda one: -one.points)
    given = set(reason.split("; "))
    reasons = (f"{one.words} ({one.file})" for one in own[:_MOST_SAID])
    also = "; ".join(one for one in reasons if one not in given)
    others = sorted((-sum_, name) for name, sum_ in points.items() if name != best and sum_ > LEAST)
    if not also and not others:
        return ""
    line = f"{best} has {points.get(best, 0.0):.0f} points"
    if also:
        line = f"{line}: also {also}"
    if others:
        named = ", ".join(f"{name} {-sum_:.0f}" for sum_, name in others[:_MOST_SAID])
        line = f"{line}; the next: {named}"
    return line


def is_decided(evidence: Sequence[Evidence]) -> bool:
    """Return whether a robot leads by so much that what says less need not be read."""
    now = ranked(evidence)
    if not now.is_sure:
        return False
    others = _sums(evidence)
    others.pop(now.best)
    return now.points - max(others.values(), default=0.0) >= CLEAR
