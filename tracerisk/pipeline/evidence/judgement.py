"""What a failure did to a mission: a run with it beside the same run without."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from tracerisk.common.evidence.cells import EFFECTS, Cell, Effect
from tracerisk.common.verdict import MISSION_MISSED, Reason
from tracerisk.pipeline.evidence.mission_run import MissionRun, Position
from tracerisk.pipeline.run.fault_run import REPORTED, finding_key
from tracerisk.trace import GOOD_ENDS, Contact, ObjectOffset, RunEnd, Visit

FALLS = frozenset({"object-dropped", "object-knocked", "object-slipped", "object-tipped"})
ARRIVAL = 0.02
"""How far off a joint may be at the end of a visit [rad, or m of a sliding one]."""
PLACED_M = 0.01
"""How much further from its goal a thing may end than without the failure [m]."""
GRASP_S = 1.0
"""A touch may be the beginning of a grasp for so long [s]; one later than that is left open."""
MOVED_M = 0.02
"""How far from where it ended without the failure a thing without a goal may end [m]."""
LATE_SHARE, LATE_S = 1.1, 1.0
"""A mission is late that takes more than this share of its time, and so many seconds [s], more."""
_ENDED_BY_ITSELF = frozenset({"ended", "quiescent"})
_OF_THE_MISSION: frozenset[Effect] = frozenset(
    {"collision", "dropped", "not_placed", "ended_badly", "wrong_position"}
)
"""The effects with which a mission failed that does not declare what it is."""


@dataclass(frozen=True, slots=True)
class _Seen:
    """One thing that happened after the failure."""

    effect: Effect
    """The kind of effect."""
    time_s: float | None
    """The instant, in simulated time [s]; `None` where it was found at the end."""
    words: str
    """What happened, in words."""


def judge(
    nominal: MissionRun, failed: MissionRun, cell: Cell, *, has_conditions: bool = False
) -> Cell:
    """Return the cell with what became of the mission in its run, beside the run without.

    A mission failed that did not reach what it reached without the failure; with
    `has_conditions`, of `success` in the scenario, one whose verdict misses a condition, or that
    collides or ends badly. Of a run that was ended because its fate was decided, what had come by
    then counts.
    """
    seen = [*_collisions(nominal, failed, cell.time_s), *_falls(nominal, failed, cell.time_s)]
    if not failed.is_decided:
        seen += [*_things(nominal, failed), *_end(nominal, failed)]
    seen += _positions(nominal, failed)
    lost: tuple[str, ...] = ()
    if has_conditions and failed.is_decided:
        fails = any(item.effect == "collision" for item in seen)
    elif has_conditions:
        missed = [reason.words for reason in _reasons(failed) if _is_missed(reason)]
        fails = bool(missed) or any(item.effect in ("collision", "ended_badly") for item in seen)
        lost = tuple(f"missed: {name}" for name in missed)
    else:
        fails = any(item.effect in _OF_THE_MISSION for item in seen)
    report = _first_report(nominal, failed, cell.time_s)
    if report is not None:
        seen.append(_Seen("told", report[0], report[1]))
    worst = min(seen, key=lambda item: EFFECTS.index(item.effect), default=None)
    same = [item for item in seen if worst is not None and item.effect == worst.effect]
    times = [item.time_s for item in same if item.time_s is not None]
    contact = max(_new_contacts(nominal, failed, cell.time_s), key=_force, default=None)
    lost += tuple(item.words for item in seen if item.effect not in ("told", "collision"))
    return replace(
        cell,
        fails=fails,
        effect="nothing" if worst is None else worst.effect,
        local=_local(failed, cell),
        told_after_s=None if report is None else round(max(0.0, report[0] - cell.time_s), 6),
        told_by="" if report is None else report[1],
        effect_after_s=round(max(0.0, min(times) - cell.time_s), 6) if times else None,
        lost=tuple(dict.fromkeys(lost)),
        contact="" if contact is None else _contact_text(contact),
        followed_s=_followed_s(failed, cell),
    )


def _followed_s(failed: MissionRun, cell: Cell) -> float | None:
    """Return how long after the failure the run ended early [s]; `None` where it did not."""
    if not failed.is_decided:
        return None
    return round(max(0.0, (failed.trace.end.simulated_s or 0.0) - cell.time_s), 6)


# What happened


def _collisions(nominal: MissionRun, failed: MissionRun, fault_s: float) -> Iterator[_Seen]:
    for contact in _new_contacts(nominal, failed, fault_s):
        yield _Seen("collision", max(contact.start_s, fault_s), _contact_text(contact))


def _new_contacts(nominal: MissionRun, failed: MissionRun, fault_s: float) -> list[Contact]:
    known = {(contact.link, contact.other) for contact in _unexpected(nominal.trace.visits)}
    latest_s = math.inf
    if failed.is_decided:
        latest_s = (failed.trace.end.simulated_s or 0.0) - GRASP_S
    return [
        contact
        for contact in _unexpected(failed.trace.visits)
        if (contact.link, contact.other) not in known
        and contact.start_s + contact.touching_s >= fault_s
        and contact.start_s <= latest_s
    ]


def _unexpected(visits: Sequence[Visit]) -> Iterator[Contact]:
    return (contact for visit in visits for contact in visit.contacts if not contact.expected)


def _force(contact: Contact) -> tuple[float, str, str]:
    return contact.force_n, contact.link, contact.other


def _contact_text(contact: Contact) -> str:
    return f"{contact.link} on {contact.other}, {contact.force_n:.3g} N"


def _falls(nominal: MissionRun, failed: MissionRun, fault_s: float) -> Iterator[_Seen]:
    before = {(reason.code, reason.object) for reason in _reasons(nominal)}
    for reason in _reasons(failed):
        if reason.code in FALLS and (reason.code, reason.object) not in before:
            yield _Seen("dropped", max(reason.time_s or 0.0, fault_s), reason.words)


def _reasons(run: MissionRun) -> tuple[Reason, ...]:
    return () if run.trace.verdict is None else run.trace.verdict.reasons


def _is_missed(reason: Reason) -> bool:
    return reason.code == MISSION_MISSED and not reason.accepted


def _things(nominal: MissionRun, failed: MissionRun) -> Iterator[_Seen]:
    """Yield what of the scene is not where it ended without the failure."""
    after = {object_offset.name: object_offset for object_offset in failed.trace.objects}
    with_goal = set()
    for object_offset in nominal.trace.objects:
        if object_offset.goal is None or not after:
            continue
        with_goal.add(object_offset.name)
        now = after.get(object_offset.name)
        if now is None or _is_worse(object_offset, now):
            yield _Seen("not_placed", None, f"{object_offset.name} not at {object_offset.goal}")
    if nominal.things is None or failed.things is None:
        return
    for name, place in nominal.things.items():
        now_at = failed.things.get(name)
        if name not in with_goal and (now_at is None or _distance(place, now_at) > MOVED_M):
            yield _Seen("not_placed", None, f"{name} not where it ended without the failure")


def _is_worse(before: ObjectOffset, now: ObjectOffset) -> bool:
    if before.goal != now.goal or (before.upright and not now.upright):
        return True
    return now.offset_m > before.offset_m + PLACED_M


def _distance(first: Position, second: Position) -> float:
    return math.dist(first, second)


def _end(nominal: MissionRun, failed: MissionRun) -> Iterator[_Seen]:
    before, now = nominal.trace.end, failed.trace.end
    if now.cause not in GOOD_ENDS:
        yield _Seen("ended_badly", now.simulated_s, f"ended by {now.cause}: {now.message}")
    elif before.cause in _ENDED_BY_ITSELF and now.cause not in _ENDED_BY_ITSELF:
        yield _Seen("ended_badly", None, f"did not end by itself: {now.cause}")
    elif (late_s := _late_s(before, now)) > 0.0:
        yield _Seen("late", None, f"{late_s:.1f} s later")


def _late_s(before: RunEnd, now: RunEnd) -> float:
    """Return by how much a run is late [s], 0 where it is not."""
    before_s, now_s = before.simulated_s or 0.0, now.simulated_s or 0.0
    return now_s - before_s if now_s > LATE_SHARE * before_s + LATE_S else 0.0


def _positions(nominal: MissionRun, failed: MissionRun) -> Iterator[_Seen]:
    """Yield the first visit that did not happen as without the failure, or ended elsewhere."""
    pairs = zip_longest(nominal.trace.visits, failed.trace.visits)
    for number, (before, now) in enumerate(pairs):
        if before is None or (failed.is_decided and number >= len(failed.trace.visits) - 1):
            return  # the last visit of a run that was ended is not over
        name = before.function.name
        if now is None or now.function != before.function:
            instead = "nothing" if now is None else now.function.name
            time_s = None if now is None else now.start_s
            yield _Seen("wrong_position", time_s, f"{name} was not visited, but {instead}")
            return
        if before.outcome == "succeeded" and now.outcome != "succeeded":
            yield _Seen("wrong_position", _visit_end(failed, number), f"{name} {now.outcome}")
            return
        if number >= min(len(nominal.arrivals), len(failed.arrivals)):
            continue
        off = _furthest(nominal.arrivals[number], failed.arrivals[number])
        if off is not None:
            joint, far = off
            words = f"{joint} off by {far:.3g} after {name}"
            yield _Seen("wrong_position", _visit_end(failed, number), words)
            return


def _visit_end(run: MissionRun, number: int) -> float | None:
    visits = run.trace.visits
    if number + 1 < len(visits):
        return visits[number + 1].start_s
    return run.trace.end.simulated_s


def _furthest(before: Mapping[str, float], now: Mapping[str, float]) -> tuple[str, float] | None:
    """Return the joint that is furthest off, and how far; `None` where all are as they should."""
    off = {name: abs(now.get(name, math.inf) - position) for name, position in before.items()}
    joint = max(off, key=lambda name: (off[name], name), default=None)
    return (joint, off[joint]) if joint is not None and off[joint] > ARRIVAL else None


def _first_report(
    nominal: MissionRun, failed: MissionRun, fault_s: float
) -> tuple[float, str] | None:
    """Return when an interface first reported a failure that the run without did not have."""
    known = {finding_key(finding) for finding in nominal.trace.findings}
    pairs = [
        (finding.time_s or 0.0, finding.kind)
        for finding in failed.trace.findings
        if finding.kind in REPORTED
        and (finding.time_s or 0.0) >= fault_s
        and finding_key(finding) not in known
    ]
    return min(pairs, default=None)


def _local(failed: MissionRun, cell: Cell) -> str:
    """Return what the unit itself did, in words."""
    match cell.mode:
        case "dead" | "jam":
            far = failed.unit_moved
            if far < 1e-3:
                return "stayed on its way within a second"
            return f"off its way by {far:.2g} within a second"
        case "no_force":
            return "no force between the fingers"
        case "opens":
            return "fingers opened"
        case "stuck":
            return "fingers stayed"
        case "offset" | "frozen" | "absent":
            return f"reading {cell.mode}" if cell.unit != "control" else "commands frozen"
    return "no motor has torque"
