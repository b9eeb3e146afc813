"""Compare a run in another world with the run itself: what of verdict and outcome depends on it.

What a world changes by itself is no dependence: when things happen, by which way and in which
posture the arm comes to a place, what is done in addition, and how often a stream of messages
goes out. docs/worlds.md lists what counts.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import kept_outcome, outcome_summary
from tracerisk.common.outcome.outcome import CellUse, GripperUse, Outcome, Rest
from tracerisk.common.outcome.tolerances import Tolerances
from tracerisk.common.verdict import GAPS, Reason, VerdictKind
from tracerisk.common.worlds.world import World
from tracerisk.common.worlds.world_run import WorldRun
from tracerisk.errors import Location
from tracerisk.trace import Trace

Lost = tuple[str, str, int]
"""What the world reached: a message that was lost, a reading; words, file and line."""

_WIDER = 5.0
"""How many times the tolerances of outcomes two worlds may differ: contacts depend on timing."""
_RANK: dict[VerdictKind, int] = {"complete": 0, "partial": 1, "faulted": 2, "stuck": 3}
_ASSUMED = GAPS | {"input-assumed", "robot-assumed", "duration-cut", "command-cut"}
"""The codes of reasons that say what was assumed or left out, and not what went wrong."""
_OF_CUT = frozenset({"command-left-on", "never-grasped", "never-released"})
"""The codes of reasons that say how a loop without an end stood when it was cut."""
_STREAM = 4
"""A topic that gets as many messages in both runs is one whose messages are not counted."""


def compared(
    world: World, nominal: Trace, trace: Trace, tolerances: Tolerances, lost: tuple[Lost, ...] = ()
) -> WorldRun:
    """Return what of a run's verdict and outcome depends on a world."""
    assert nominal.verdict is not None
    assert trace.verdict is not None
    known = Counter(_key(reason) for reason in nominal.verdict.open_reasons)
    left_out = _ASSUMED | (_OF_CUT if is_endless(nominal) else frozenset())
    new = [
        reason
        for reason in trace.verdict.open_reasons
        if reason.code not in left_out and _key(reason) not in known
    ]
    # What makes it partial alone is in its reasons.
    is_worse = _RANK[trace.verdict.kind] > max(_RANK[nominal.verdict.kind], _RANK["partial"])
    differs = differences(world, nominal, trace, tolerances)
    if is_worse and not new and not differs:
        differs = (f"the run ends differently: {trace.end.message}",)
    run = WorldRun(
        world.name,
        trace.verdict.kind,
        new[0].message if new else "",
        differs,
    )
    if not run.depends:
        return run
    return _with_cause(run, new, lost)


def _key(reason: Reason) -> tuple[str, str]:
    """Return what makes a reason another one; its object may be a time or a place in words."""
    return reason.code, reason.function


def _with_cause(run: WorldRun, new: list[Reason], lost: tuple[Lost, ...]) -> WorldRun:
    """Return a run with the line that it depends on: what the world reached, else what failed."""
    if lost:
        words, file, line = lost[0]
        return replace(run, cause=words, location=Location(file, line or None))
    places = [reason.location for reason in new if reason.location is not None]
    return replace(run, location=places[0] if places else None)


def differences(
    world: World, nominal: Trace, trace: Trace, tolerances: Tolerances
) -> tuple[str, ...]:
    """Return what a run in a world did not bring about as the run itself did, a sentence each."""
    if nominal.outcome is None or trace.outcome is None:
        return ()
    wide = Tolerances(
        _WIDER * tolerances.place_m, _WIDER * tolerances.angle_deg, _WIDER * tolerances.joint
    )
    passed = _without_passed(nominal.outcome, trace.outcome, wide)
    old, new = (
        kept_outcome(outcome_summary(_told(outcome))) for outcome in (passed, trace.outcome)
    )
    if old is None or new is None:
        return ()
    old, new = _without_streams(old, new)
    if world.gripper is not None:
        # Whether the first command moves a gripper is the world's doing.
        old, new = _without_first_grip(old), _without_first_grip(new)
    if not is_endless(nominal):
        changes = outcome_changes(old, new, wide)
        return (*changes.result, *changes.lost)
    # Where in its cycle a loop without an end is cut says nothing.
    old, new = _first(old, len(old.steps) * 3 // 4), _first(new, len(old.steps))
    return outcome_changes(old, new, wide).lost


def is_endless(trace: Trace) -> bool:
    """Return whether a run is of a loop without an end, which something else ended."""
    return trace.end.cause in ("cycles", "duration")


def _first(outcome: Outcome, number: int) -> Outcome:
    """Return an outcome with its first steps alone."""
    kept = outcome.steps[:number]
    return replace(
        outcome,
        rests=tuple(step for step in kept if isinstance(step, Rest)),
        grips=tuple(step for step in kept if isinstance(step, GripperUse)),
        cell=tuple(step for step in kept if isinstance(step, CellUse)),
    )


def _without_passed(old: Outcome, new: Outcome, tolerances: Tolerances) -> Outcome:
    """Return an outcome without the rests that the other passes without coming to rest there.

    Who sleeps just as long as a motion lasts goes on a few milliseconds before its end.
    """
    corners = [corner for rest in new.rests for corner in rest.via_m]
    last = {rest.arm: rest for rest in old.rests}

    def is_passed(rest: Rest) -> bool:
        return any(math.dist(rest.tool_m, corner) <= tolerances.place_m for corner in corners)

    kept = [rest for rest in old.rests if rest is last[rest.arm] or not is_passed(rest)]
    return replace(old, rests=tuple(kept))


def _told(outcome: Outcome) -> Outcome:
    """Return an outcome without the ways between its rests: any way will do."""
    rests = tuple(replace(rest, via_m=()) for rest in outcome.rests)
    return replace(outcome, rests=rests, corner_m=0.0)


def _without_streams(old: Outcome, new: Outcome) -> tuple[Outcome, Outcome]:
    """Return both without the topics on which each sends many messages, at a rate or not.

    What the second alone asks of the cell goes too: it comes in addition.
    """
    many = {*old.streams, *new.streams}
    counts = [
        Counter(use.interface for use in outcome.cell if use.kind == "message")
        for outcome in (old, new)
    ]
    many |= {name for name in counts[0] if min(count[name] for count in counts) >= _STREAM}
    # A stream that has ceased is none: its messages are counted.
    many -= {name for name in old.streams if name not in new.streams and not counts[1][name]}
    many |= {count.interface for count in new.cell_counts} - {
        *old.streams,
        *(count.interface for count in old.cell_counts),
    }

    def quiet(outcome: Outcome) -> Outcome:
        return replace(
            outcome,
            cell=tuple(use for use in outcome.cell if use.interface not in many),
            counts=tuple(
                cell_count for cell_count in outcome.counts if cell_count.interface not in many
            ),
            streams=tuple(name for name in outcome.streams if name not in many),
        )

    return quiet(old), quiet(new)


def _without_first_grip(outcome: Outcome) -> Outcome:
    first: dict[str, GripperUse] = {}
    for use in outcome.grips:
        first.setdefault(use.gripper, use)
    kept = tuple(use for use in outcome.grips if use is not first[use.gripper] or use.holds)
    return replace(outcome, grips=kept)
