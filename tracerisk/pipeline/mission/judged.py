"""Judge what a run brought about against what `success` of its scenario declares."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.outcome.outcome import FLOOR
from tracerisk.pipeline.mission.asked_calls import AskedCall
from tracerisk.pipeline.mission.bodies import (
    Clause,
    length_words,
    link_clause,
    link_places,
    object_clauses,
)
from tracerisk.pipeline.mission.facts import MissionFacts
from tracerisk.ros.scenario.success import COUNTED, Condition, place_words, times_words

_STILL = 0.02
"""The arm stops where none of its joints is faster [rad/s, or m/s of a sliding one]."""
_VISIT_END_S = 0.02
"""What is found so near to the end of a visit is found at it [s]."""

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Missed:
    """A condition that a run did not meet."""

    condition: Condition
    """The condition as declared."""
    words: str
    """What the run shows, and what the condition allows."""


def missed(conditions: Iterable[Condition], facts: MissionFacts) -> tuple[Missed, ...]:
    """Return the conditions that a run did not meet, in their order."""
    generator = ((condition, _found(condition, facts)) for condition in conditions)
    return tuple(Missed(condition, words) for condition, words in generator if words)


def _found(condition: Condition, facts: MissionFacts) -> str:
    """Return what was found instead of a condition; empty where it is met."""
    match condition.kind:
        case "within_s":
            if facts.end_s <= condition.seconds:
                return ""
            return f"the run ends at {facts.end_s:g} s (at most {condition.seconds:g} s allowed)"
        case "visited" | "called" | "sent":
            return _count_found(condition, facts)
        case "steps":
            return _steps_found(condition, facts)
    if facts.samples is None or not facts.samples.n_steps:
        return f"nothing was simulated, so this cannot be: {condition.words}"
    absent = _absent(condition, facts)
    if absent:
        return f"there was no object '{absent}' in the run: {condition.words}"
    if condition.kind in ("reached", "passed"):
        return _way_found(condition, facts)
    clauses = _clauses(condition, facts, np.array([facts.end_s]))
    words = "; ".join(clause.words(0) for clause in clauses if not clause.is_met[0])
    return f"the arm ends {words}" if words and condition.kind == "joints" else words


def _absent(condition: Condition, facts: MissionFacts) -> str:
    names = [condition.of, condition.rests_on, condition.name if condition.kind == "object" else ""]
    goals = {goal.name for goal in facts.scene.goals}
    if isinstance(condition.at, str) and condition.at not in goals:
        names.append(condition.at)
    known = {*facts.tracks, *facts.frames, FLOOR}
    return next((name for name in names if name and name not in known), "")


def _clauses(condition: Condition, facts: MissionFacts, times: Array) -> list[Clause]:
    match condition.kind:
        case "object":
            return list(object_clauses(condition, facts, times))
        case "link":
            return [link_clause(condition, facts, times)]
    return [_arm_clause(condition, facts, times)]


# Where the arm was


def _arm_clause(condition: Condition, facts: MissionFacts, times: Array) -> Clause:
    """Return whether joints or links are where a condition wants them, at some times."""
    off = _distances(condition, facts, times)
    names = [f"{name} = {value:g}" for name, value in condition.joints.items()]
    names += [f"{name} = {place_words(place)}" for name, place in condition.links.items()]

    def words(index: int) -> str:
        worst = int(off[:, index].argmax())
        away, most = (
            length_words(value) if condition.links else f"{value:.3g}"
            for value in (float(off[worst, index]), condition.within)
        )
        return f"{away} from {names[worst]} (at most {most} allowed)"

    return Clause(off.max(axis=0) <= condition.within, words)


def _distances(condition: Condition, facts: MissionFacts, times: Array) -> Array:
    """Return how far each joint or link of a condition is from its place, (n_parts, n_times)."""
    samples = facts.samples
    assert samples is not None
    steps = np.clip(np.round(times / samples.step_s).astype(int), 0, samples.n_steps - 1)
    off: list[Array] = []
    for name, value in condition.joints.items():
        position = samples.position[steps, samples.header.joints.index(name)]
        off.append(np.abs(position - value))
    for name, place in condition.links.items():
        off.append(np.linalg.norm(link_places(facts, name, times) - np.array(place), axis=1))
    return np.array(off)


def _stops(facts: MissionFacts) -> Flags:
    """Return in which steps the arm stands still, or a visit ends, (n_steps,)."""
    samples = facts.samples
    assert samples is not None
    arm = {joint.name for joint in facts.robot.arm_joints}
    columns = [i for i, name in enumerate(samples.header.joints) if name in arm]
    still: Flags = np.all(np.abs(samples.velocity[:, columns]) < _STILL, axis=1)
    near = round(_VISIT_END_S / samples.step_s)
    for visit in facts.visits[1:]:
        step = round(visit.start_s / samples.step_s)
        still[max(0, step - near) : step + 1] = True
    return still


def _way(condition: Condition, facts: MissionFacts) -> tuple[Clause, Flags]:
    """Return how the arm met a condition at each step, and in which steps that counts."""
    clause = _arm_clause(condition, facts, facts.times)
    if condition.kind == "passed":
        return clause, np.ones(len(facts.times), dtype=np.bool_)
    return clause, _stops(facts)


def _way_found(condition: Condition, facts: MissionFacts) -> str:
    clause, counts = _way(condition, facts)
    if bool((clause.is_met & counts).any()):
        return ""
    far = _distances(condition, facts, facts.times).max(axis=0)
    nearest = int(np.where(counts, far, np.inf).argmin())
    verb = "stops at" if condition.kind == "reached" else "passes"
    return (
        f"the arm never {verb} the declared pose; it comes nearest at "
        f"{facts.times[nearest]:.1f} s, {clause.words(nearest)}"
    )


# What was called, sent and visited


def _count_found(condition: Condition, facts: MissionFacts) -> str:
    times, lacking = _event_times(condition, facts)
    count = len(times)
    if not condition.fields and condition.kind != "visited":
        count = facts.counts.get(condition.name, 0)
    if count == condition.times or (count > condition.times and not condition.is_exact):
        return ""
    verb = {"visited": "succeeded", "called": "was called", "sent": "was published to"}
    values = ", ".join(f"{path} = {value}" for path, value in condition.fields.items())
    how = "" if condition.is_exact else "at least "
    return (
        f"{condition.name} {verb[condition.kind]} {times_words(count)}"
        f"{f' with {values}' if values else ''} ({how}{times_words(condition.times)} asked)"
        f"{lacking}"
    )


def _event_times(condition: Condition, facts: MissionFacts) -> tuple[list[float], str]:
    """Return when what a condition counts happened [s], and fields that its messages lack."""
    if condition.kind == "visited":
        ends = [*(visit.start_s for visit in facts.visits[1:]), facts.end_s]
        return [
            end
            for visit, end in zip(facts.visits, ends, strict=False)
            if visit.function.name == condition.name and visit.outcome == "succeeded"
        ], ""
    own = [call for call in facts.calls if call.name == condition.name]
    lacking = ""
    for call in own:
        for path, known in call.lacks.items():
            if path in condition.fields:
                lacking = f"; it has no field '{path}', but {', '.join(known) or 'none'}"
    return [call.time_s for call in own if _agrees(condition.fields, call)], lacking


def _agrees(fields: Mapping[str, Any], call: AskedCall) -> bool:
    return all(
        path in call.fields and _is_equal(call.fields[path], value)
        for path, value in fields.items()
    )


def _is_equal(found: Any, wanted: Any) -> bool:
    """Return whether two values are the same; numbers as closely as 32 bits hold them."""
    if isinstance(found, list) and isinstance(wanted, list):
        pairs = zip(found, wanted, strict=False)
        return len(found) == len(wanted) and all(_is_equal(one, two) for one, two in pairs)
    numbers = all(isinstance(value, int | float) for value in (found, wanted))
    if numbers and not any(isinstance(value, bool) for value in (found, wanted)):
        return math.isclose(found, wanted, rel_tol=1e-6, abs_tol=1e-9)
    return bool(found == wanted)


# One after the other


def _steps_found(condition: Condition, facts: MissionFacts) -> str:
    before_s, earlier = -math.inf, ""
    for number, step in enumerate(condition.steps, start=1):
        absent = _absent(step, facts)
        if absent:
            return f"step {number} cannot come: there was no object '{absent}' in the run"
        times = _times_of(step, facts)
        # A state is known at each step of the samples, the last of them before the end.
        margin_s = 0.0 if step.kind in COUNTED or facts.samples is None else facts.samples.step_s
        later = [time_s for time_s in times if time_s >= before_s - margin_s]
        if len(later) < step.times:
            what = f"step {number} ({step.words})"
            if not times:
                return f"{what} never came"
            return f"{what} does not come after {earlier}: it came last at {times[-1]:.1f} s"
        before_s = max(before_s, later[step.times - 1])
        earlier = f"step {number} ({step.words}), which came at {before_s:.1f} s"
        if step.kind in COUNTED:
            # One call is one step; a pose may be kept from the step before on.
            before_s = math.nextafter(before_s, math.inf)
    return ""


def _times_of(step: Condition, facts: MissionFacts) -> Sequence[float]:
    """Return the times at which a step holds or happens, rising [s]."""
    if step.kind in COUNTED:
        return _event_times(step, facts)[0]
    if facts.samples is None or not facts.samples.n_steps:
        return ()
    times = facts.times
    if step.kind in ("reached", "passed"):
        clause, counts = _way(step, facts)
        is_met = clause.is_met & counts
    else:
        clauses = _clauses(step, facts, times)
        is_met = np.logical_and.reduce([clause.is_met for clause in clauses])
        if step.kind != "object":
            is_met = is_met & _stops(facts)
    tolist: list[float] = times[is_met].tolist()
    return tolist
