"""Draft from the outcome of a good run what its mission is: conditions that nobody confirmed."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.common.outcome.outcome import MOVED_M, ObjectOutcome, Outcome
from tracerisk.pipeline.mission.bodies import GOAL_HEIGHT_M, UPRIGHT_RAD, length_words
from tracerisk.ros.scenario.file.lines import marked_entry
from tracerisk.ros.scenario.success import Condition, times_words
from tracerisk.twin.physics.scene import Goal

_GOAL_M = 0.01
"""An object that ends no further from a goal of the scene is meant to be there [m]."""
_TILT_RAD = 0.1
"""How far an object that stands may lean [rad]."""


@dataclass(frozen=True, slots=True)
class DraftedCondition:
    """A condition that a run met, and that nobody has confirmed."""

    value: Mapping[str, Any]
    """The entry of `success`."""
    words: str
    """What the run showed."""

    @property
    def lines(self) -> list[str]:
        """The lines of the entry in a scenario, with the mark."""
        return marked_entry(self.value, self.words)

    @property
    def subjects(self) -> frozenset[tuple[str, str]]:
        """The kind of the condition with each name that it says something of."""
        kind, named = next(iter(self.value.items()))
        return frozenset((kind, name) for name in ((named,) if kind != "joints" else named))


def drafted_conditions(
    outcome: Outcome, goals: Sequence[Goal], known: Iterable[Condition] = (), *, is_over: bool
) -> tuple[DraftedCondition, ...]:
    """Return what a run brought about as conditions, but what `known` ones speak of already.

    `goals` are those of the scene. `is_over`: the controller came to its end, so that the arm
    rests where it is to.
    """
    said: set[tuple[str, str]] = set()
    for condition in known:
        named = condition.joints if condition.kind == "joints" else (condition.name,)
        said |= {(condition.kind, name) for name in named}
    rests = _rests(outcome) if is_over else ()
    result = (*_objects(outcome, goals), *_uses(outcome), *rests)
    return tuple(drafted for drafted in result if not said.intersection(drafted.subjects))


def _objects(outcome: Outcome, goals: Sequence[Goal]) -> Iterator[DraftedCondition]:
    moved = {object_outcome.name for object_outcome in outcome.moved}
    for object_outcome in outcome.objects:
        if object_outcome.name not in moved:
            value: dict[str, Any] = {"object": object_outcome.name, "moved": False}
            yield DraftedCondition(value, "it stayed where it was")
            continue
        far_m = math.dist(object_outcome.begin_m, object_outcome.end_m)
        words = [f"the run moved it by {length_words(far_m)}"] if far_m > MOVED_M else []
        words += ["it is held at the end"] if object_outcome.held_in else []
        yield DraftedCondition(
            {"object": object_outcome.name, **_end(object_outcome, goals)}, " and ".join(words)
        )


def _end(found: ObjectOutcome, goals: Sequence[Goal]) -> dict[str, Any]:
    """Return where an object ends, as the keys of a condition."""
    if found.held_in:
        return {"held_by": found.held_in.split("+")[0]}
    stands = math.radians(found.tilt_deg) < UPRIGHT_RAD
    x, y, z = found.end_m
    for goal in goals:
        off = math.hypot(x - goal.xyz[0], y - goal.xyz[1])
        if stands and off <= _GOAL_M and abs(z - goal.xyz[2]) < GOAL_HEIGHT_M:
            return {"at": goal.name}
    value: dict[str, Any] = {"at": list(found.end_m), "within": MOVED_M}
    if stands:
        value["tilt"] = _TILT_RAD
    if found.rests_on and "+" not in found.rests_on:
        value["rests_on"] = found.rests_on
    return value


def _uses(outcome: Outcome) -> Iterator[DraftedCondition]:
    """Yield how often the cell was used; the number of a stream is only its time."""
    kinds = {"call": "called", "goal": "called", "message": "sent"}
    counts = Counter((kinds[use.kind], use.interface) for use in outcome.cell)
    for (kind, name), count in sorted(counts.items()):
        value = {kind: name, "exactly": count}
        yield DraftedCondition(value, f"the run did so {times_words(count)}")
    for name in outcome.streams:
        yield DraftedCondition({"sent": name}, "the run did so at a steady rate")


def _rests(outcome: Outcome) -> Iterator[DraftedCondition]:
    """Yield where each arm rests last."""
    for number, arm in enumerate(outcome.arms):
        rest = next((rest for rest in reversed(outcome.rests) if rest.arm == number), None)
        if rest is not None:
            joints = dict(zip(arm.joints, rest.joints, strict=True))
            yield DraftedCondition({"joints": joints}, "the arm rests there at the end of the run")
