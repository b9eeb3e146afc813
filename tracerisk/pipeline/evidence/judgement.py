"""What a failure did to a mission and who noticed: a run with it beside the same run without."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from tracerisk.common.evidence.cells import EFFECTS, UNDETECTED, Cell, Effect, Fate
from tracerisk.common.hardware.model import CONTROL, mode_and_duration
from tracerisk.common.traced.elements import Contact
from tracerisk.common.verdict import MISSION_MISSED, Reason
from tracerisk.pipeline.evidence.missed_checks import missed_check
from tracerisk.pipeline.evidence.mission_run import MissionRun, Position
from tracerisk.pipeline.evidence.reaction import Reaction, reaction_to
from tracerisk.pipeline.run.fault_run import new_reports
from tracerisk.trace import GOOD_ENDS, ObjectOffset, RunEnd, Visit

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
BORNE_N = 65.0
"""The force with which a thing may touch what it belongs to, or what it rolls against [N]: the
least that a part of the body is to bear in a lasting contact, that of the face
(ISO/TS 15066:2016, table A.2)."""
_HARM: frozenset[Effect] = frozenset({"collision", "dropped"})
"""The effects that stop a controller too late."""
_SETTLED_S = 0.5
"""For how long a robot that was stopped may come to rest [s]."""
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
    name: str = ""
    """The thing that fell; empty for all other effects."""


def judge(
    nominal: MissionRun, failed: MissionRun, cell: Cell, *, has_conditions: bool = False
) -> Cell:
    """Return the cell with what became of the mission in its run, beside the run without.

    A mission failed that did not reach what it reached without the failure; with
    `has_conditions`, of `success` in the scenario, one whose verdict misses a condition, or that
    collides or ends badly. Of a run that was ended because its fate was decided, what had come by
    then counts.
    """
    fallen = list(_falls(nominal, failed, cell.time_s))
    seen = [*_touches(nominal, failed, cell.time_s, fallen), *fallen]
    if not failed.is_decided:
        seen += [*_things(nominal, failed), *_end(nominal, failed)]
    seen += _positions(nominal, failed)
    lost: tuple[str, ...] = ()
    if has_conditions and failed.is_decided:
        fails = any(item.effect == "collision" for item in seen)
    elif has_conditions:
        lost = tuple(f"missed: {item.words}" for item in _reasons(failed) if _is_missed(item))
        fails = bool(lost) or any(item.effect in ("collision", "ended_badly") for item in seen)
    else:
        fails = any(item.effect in _OF_THE_MISSION for item in seen)
    reaction = reaction_to(nominal, failed, cell.time_s)
    fate = _fate(failed, reaction, seen, fails=fails)
    shown_s = _first_shown(seen, reaction, failed)
    missed = None
    if fails and fate in UNDETECTED:
        effect_s = math.inf if shown_s is None else shown_s
        missed = missed_check(nominal, failed, cell, reaction, effect_s)
    report = _first_report(nominal, failed, cell.time_s)
    if report is not None:
        seen.append(_Seen("told", report[0], report[1]))
    worst = min(seen, key=lambda item: EFFECTS.index(item.effect), default=None)
    same = [item for item in seen if worst is not None and item.effect == worst.effect]
    times = [item.time_s for item in same if item.time_s is not None]
    contact = max(_new_contacts(nominal, failed, cell.time_s), key=_force, default=None)
    lost += tuple(
        item.words for item in seen if item.effect not in ("told", "touched", "collision")
    )
    return replace(
        cell,
        fails=fails,
        effect="nothing" if worst is None else worst.effect,
        effects=tuple(sorted({item.effect for item in seen}, key=EFFECTS.index)),
        fate=fate,
        noticed_by=reaction.noticed_by,
        noticed_s=_after(reaction.noticed_s, cell),
        shows_in=_function_of(failed, shown_s),
        next_function=_function_from(nominal, failed, reaction.next_s),
        missed_check=None if missed is None else missed[0],
        missed_at="" if missed is None else missed[1],
        local=_local(failed, cell),
        told_after_s=None if report is None else _after(report[0], cell),
        told_by="" if report is None else report[1],
        effect_after_s=_after(min(times, default=None), cell),
        lost=tuple(dict.fromkeys(lost)),
        contact="" if contact is None else _contact_text(contact),
        followed_s=_followed_s(failed, cell),
    )


def _followed_s(failed: MissionRun, cell: Cell) -> float | None:
    """Return how long after the failure the run ended early [s]; `None` where it did not."""
    if not failed.is_decided:
        return None
    return _after(failed.trace.end.simulated_s or 0.0, cell)


def _after(time_s: float | None, cell: Cell) -> float | None:
    """Return how long after the failure something happened [s]; `None` where it did not."""
    return None if time_s is None else round(max(0.0, time_s - cell.time_s), 6)


# What the controller made of it


def _fate(failed: MissionRun, reaction: Reaction, seen: Sequence[_Seen], *, fails: bool) -> Fate:
    if not fails:
        return "recovered" if reaction.is_other_way else "carried_out"
    if reaction.noticed_s is None:
        return "unaware"
    rest_s = max(reaction.noticed_s, reaction.rest_s) + _SETTLED_S
    is_late = (
        reaction.went_on
        or any(item.effect in _HARM for item in seen)
        or failed.moved_after(rest_s) > ARRIVAL
    )
    return "stopped_late" if is_late else "stopped_safely"


def _first_shown(seen: Sequence[_Seen], reaction: Reaction, failed: MissionRun) -> float | None:
    """Return when the failure first shows in its effects, or to the controller [s]."""
    times = [item.time_s for item in seen if item.time_s is not None]
    times += [] if reaction.noticed_s is None else [reaction.noticed_s]
    return min(times, default=failed.trace.end.simulated_s if seen else None)


def _function_of(run: MissionRun, time_s: float | None) -> str:
    """Return the function whose visit led to an instant; empty for none."""
    if time_s is None:
        return ""
    begun = [visit for visit in run.trace.visits if visit.start_s < time_s]
    return str(begun[-1].function.name) if begun else ""


def _function_from(nominal: MissionRun, failed: MissionRun, time_s: float | None) -> str:
    """Return the function that commands from an instant on; empty for none.

    It is the first that also runs without the failure; if there is none, the first of all.
    """
    if time_s is None:
        return ""
    now = _function_of(failed, math.nextafter(time_s, math.inf))
    later = [visit.function.name for visit in failed.trace.visits if visit.start_s > time_s]
    known = {visit.function.name for visit in nominal.trace.visits}
    return next((str(name) for name in (now, *later) if name in known), now)


# What happened


def _touches(
    nominal: MissionRun, failed: MissionRun, fault_s: float, fallen: Sequence[_Seen]
) -> Iterator[_Seen]:
    """Yield what touched that does not touch without the failure: collisions, and touches.

    A touch that is borne is none where a thing is carried that touches the same body without the
    failure too, which is where it came from or goes, and where it fell before.
    """
    supports = {
        (contact.link, contact.other)
        for visit in nominal.trace.visits
        for contact in visit.contacts
        if contact.expected
    }
    fell_s = {item.name: item.time_s or 0.0 for item in fallen}
    for contact in _new_contacts(nominal, failed, fault_s):
        is_own = (contact.link, contact.other) in supports and contact.link in _things_in(nominal)
        has_fallen = any(
            fell_s.get(name, math.inf) <= contact.start_s for name in (contact.link, contact.other)
        )
        is_borne = contact.force_n <= BORNE_N and (is_own or has_fallen)
        effect: Effect = "touched" if is_borne else "collision"
        yield _Seen(effect, max(contact.start_s, fault_s), _contact_text(contact))


def _things_in(run: MissionRun) -> frozenset[str]:
    return frozenset(item.name for item in run.trace.objects).union(run.things or ())


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
            at_s = max(reason.time_s or 0.0, fault_s)
            yield _Seen("dropped", at_s, reason.words, reason.object)


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
        name, now = object_offset.name, after.get(object_offset.name)
        # The nearest free goal of a thing astray is another one where another thing left its own.
        if now is not None and now.goal != object_offset.goal and not object_offset.stands_at_goal:
            is_worse = _is_elsewhere(name, nominal, failed)
        else:
            is_worse = now is None or _is_worse(object_offset, now)
        if is_worse:
            yield _Seen("not_placed", None, f"{name} not at {object_offset.goal}")
    if nominal.things is None or failed.things is None:
        return
    for name in nominal.things:
        if name not in with_goal and _is_elsewhere(name, nominal, failed):
            yield _Seen("not_placed", None, f"{name} not where it ended without the failure")


def _is_elsewhere(name: str, nominal: MissionRun, failed: MissionRun) -> bool:
    """Return whether a thing is not where it ended without the failure, or nobody knows."""
    before, now = ((run.things or {}).get(name) for run in (nominal, failed))
    return before is None or now is None or _distance(before, now) > MOVED_M


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
    reports = new_reports(nominal.trace, failed.trace, fault_s)
    return min(((finding.time_s or 0.0, finding.kind) for finding in reports), default=None)


def _local(failed: MissionRun, cell: Cell) -> str:
    """Return what the unit itself did, in words."""
    match mode_and_duration(cell.mode)[0]:
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
        case "link_lost":
            return "no communication with the arm"
        case "frozen" if cell.unit == CONTROL:
            return "commands frozen"
        case "offset" | "frozen" | "absent" | "noisy" as mode:
            far = failed.unit_moved
            off = f", joint off its way by {far:.2g} within a second" if far >= 1e-3 else ""
            return f"reading {mode}{off}"
    return "no motor has torque"
