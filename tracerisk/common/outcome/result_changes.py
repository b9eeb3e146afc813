"""What of the result of two runs differs: where objects end, and what the cell was asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tracerisk.common.outcome.arm import Position
from tracerisk.common.outcome.outcome import (
    CellCount,
    GripperUse,
    ObjectOutcome,
    Outcome,
    Rest,
)
from tracerisk.common.outcome.tolerances import ROUNDING, Tolerances, is_same_content

_SET_DOWN_M = 0.05  # how near two places are at which an object is set down on one thing
VERBS = {"call": "is called", "message": "gets a message", "goal": "gets a goal"}
"""What happens to an interface of the cell when it is used, by the kind of use."""


def object_changes(old: Outcome, new: Outcome, limits: Tolerances) -> list[str]:
    """Return what of the objects ends otherwise."""
    before = {object_outcome.name: object_outcome for object_outcome in old.objects}
    after = {object_outcome.name: object_outcome for object_outcome in new.objects}
    lines: list[str] = []
    for name in sorted({*before, *after}):
        if name not in after:
            lines.append(f"{name} is no longer in the scene{_was_moved(before[name], limits)}")
        elif name not in before:
            lines.append(f"{name} is new in the scene{_is_moved(after[name], limits)}")
        else:
            lines += _object(before[name], after[name], limits)
    return lines


def _moved_m(found: ObjectOutcome, limits: Tolerances) -> float:
    """Return how far an object ends from where it began [m]; 0 where it was not moved."""
    off = math.dist(found.begin_m, found.end_m)
    return off if off > limits.place_m else 0.0


def _is_moved(found: ObjectOutcome, limits: Tolerances) -> str:
    """Return what a run did with an object that the earlier one did not have."""
    off = _moved_m(found, limits)
    if found.held_in:
        return f" and ends held in {found.held_in}"
    if not off:
        return " and is not moved"
    to = position_words(found.end_m)
    return f" and is moved by {millimetres(off)} to {to}, ends on {found.rests_on or 'nothing'}"


def _was_moved(found: ObjectOutcome, limits: Tolerances) -> str:
    """Return what the earlier run did with an object that the later one does not have."""
    off = _moved_m(found, limits)
    if found.held_in:
        return f", before: it ended held in {found.held_in}"
    return f", before: it was moved by {millimetres(off)}" if off else ""


def _object(old: ObjectOutcome, new: ObjectOutcome, limits: Tolerances) -> Iterator[str]:
    name = old.name
    if old.held_in != new.held_in:
        yield f"{name} ends {_held(new)}, before: {_held(old)}"
        return
    off = math.dist(old.end_m, new.end_m)
    tipped = abs(old.tilt_deg - new.tilt_deg)
    if off > limits.place_m * ROUNDING:
        was_moved, is_moved = _moved_m(old, limits), _moved_m(new, limits)
        if was_moved and not is_moved:
            yield f"{name} is no longer moved"
            return
        elif is_moved and not was_moved:
            to = position_words(new.end_m)
            yield f"{name} is moved by {millimetres(is_moved)} to {to}, before: not moved"
        else:
            yield f"{name} {ends_elsewhere(old.end_m, new.end_m)}"
    if tipped > limits.angle_deg * ROUNDING:
        yield f"{name} ends tilted by {new.tilt_deg:.0f} deg, before: {old.tilt_deg:.0f} deg"
    elif old.heading_deg is not None and new.heading_deg is not None and new.tilt_deg < 45.0:
        turned = abs((old.heading_deg - new.heading_deg + 180.0) % 360.0 - 180.0)
        if turned > limits.angle_deg * ROUNDING:
            yield f"{name} ends turned by {turned:.0f} deg from how it ended"
    if old.rests_on != new.rests_on and off > limits.place_m * ROUNDING:
        yield f"{name} ends on {new.rests_on or 'nothing'}, before: {old.rests_on or 'nothing'}"


def cell_changes(old: Outcome, new: Outcome) -> list[str]:
    """Return what was asked of the cell otherwise."""
    lines: list[str] = []
    before = {count.interface: count for count in old.cell_counts}
    after = {count.interface: count for count in new.cell_counts}
    for name in sorted({*before, *after} - {*old.streams, *new.streams}):
        lines += _interface(before.get(name), after.get(name), old, new)
    for name in sorted({*old.streams} ^ {*new.streams}):
        was, now = (
            "at a steady rate"
            if name in outcome.streams
            else _times(counts[name].uses if name in counts else 0)
            for outcome, counts in ((old, before), (new, after))
        )
        lines.append(f"messages are sent on {name} {now}, before: {was}")
    return lines


def _interface(
    before: CellCount | None, after: CellCount | None, old: Outcome, new: Outcome
) -> Iterator[str]:
    known = after or before
    assert known is not None, "one of the runs used it"
    name, verb = known.interface, VERBS[known.kind]
    was, now = (0 if count is None else count.uses for count in (before, after))
    if was != now or before is None or after is None:
        yield f"{name} {verb} {_times(now)}, before: {_times(was)}"
    elif before.succeeded != after.succeeded:
        yield f"{name} succeeds {_times(after.succeeded)}, before: {_times(before.succeeded)}"
    elif not old.left_out and not new.left_out:
        yield from _contents(name, old, new)


def _contents(name: str, old: Outcome, new: Outcome) -> Iterator[str]:
    gone = [use for use in old.cell if use.interface == name]
    come = []
    for use in (use for use in new.cell if use.interface == name):
        same = next((was for was in gone if is_same_content(was.content, use.content)), None)
        if same is None:
            come.append(use)
        else:
            gone.remove(same)
    for was, use in zip(gone, come, strict=False):
        yield f"{name} gets {use.content or 'defaults'}, before: {was.content or 'defaults'}"


def _held(found: ObjectOutcome) -> str:
    return f"held in {found.held_in}" if found.held_in else "free"


def _times(number: int) -> str:
    return {0: "never", 1: "once", 2: "twice"}.get(number, f"{number} times")


def not_set_down(old: Outcome, new: Outcome) -> Iterator[str]:
    """Yield where an object is no longer set down on its way, whatever became of it in the end.

    Only what is set down less often counts: elsewhere is another rest. What is never set down any
    more is said to be no longer moved, or held.
    """
    before, after = set_downs(old), set_downs(new)
    for name, places in before.items():
        left = list(after.get(name, ()))
        for place in places if 0 < len(left) < len(places) else ():
            same = next((other for other in left if math.dist(place, other) <= _SET_DOWN_M), None)
            if same is None:
                yield f"{name} is no longer set down at {position_words(place)}"
            else:
                left.remove(same)


def set_downs(outcome: Outcome) -> dict[str, list[Position]]:
    """Return where the only arm let go of each object, in order; nothing of several arms."""
    places: dict[str, list[Position]] = {}
    if len(outcome.arms) != 1 or outcome.left_out:
        return places
    held: dict[str, str] = {}
    tool_m: Position | None = None
    for step in outcome.steps:
        if isinstance(step, Rest):
            tool_m = step.tool_m
        elif isinstance(step, GripperUse):
            was = held.get(step.gripper, "")
            if was and not step.holds and tool_m is not None:
                places.setdefault(was, []).append(tool_m)
            held[step.gripper] = step.holds
    return places


def newly_moved(old: Outcome, new: Outcome, limits: Tolerances) -> tuple[str, ...]:
    """Return the names of objects that only the later run moves, or has and moves."""
    before = {found.name for found in old.objects if _moved_m(found, limits)}
    moved = (found.name for found in new.objects if _moved_m(found, limits))
    return tuple(sorted(name for name in moved if name not in before))


def position_words(place: Position) -> str:
    """Return a position [m] in words."""
    return f"({', '.join(f'{value:.3f}' for value in place)}) m"


def ends_elsewhere(old: Position, new: Position) -> str:
    """Return how far from its earlier place [m] something ends, with both places."""
    apart = millimetres(math.dist(old, new))
    return (
        f"ends {apart} from where it ended, at {position_words(new)}, before: {position_words(old)}"
    )


def millimetres(length: float) -> str:
    """Return a length [m] in words, in millimetres."""
    return f"{1000.0 * length:.0f} mm"
