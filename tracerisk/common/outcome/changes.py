"""Compare what two runs brought about: result, way and pace, in sentences.

The result is where objects end, what is held, what the cell was asked for and the last rest. The
way are rests, gripper uses and the order of all steps, aligned as sequences are. The pace, how long
the arm rests and moves, is named and decides nothing.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.common.outcome.alignment import aligned
from tracerisk.common.outcome.arm import Position, angle_between
from tracerisk.common.outcome.outcome import (
    CellCount,
    CellUse,
    GripperUse,
    ObjectOutcome,
    Outcome,
    Rest,
    Step,
)
from tracerisk.common.outcome.ways import ways_apart

if TYPE_CHECKING:
    from tracerisk.config import Settings


@dataclass(frozen=True, slots=True)
class Tolerances:
    """By how much two outcomes may differ and count as the same."""

    place_m: float = 0.002
    """Of objects and of the tool at rest, [m]."""
    angle_deg: float = 2.0
    """Of an object's tilt and heading, [deg]."""
    joint: float = 0.005
    """Of a joint at rest, [rad or m]."""

    @classmethod
    def of(cls, settings: Settings) -> Tolerances:
        """Return those of the settings."""
        return cls(
            settings.outcome_place_mm / 1000.0,
            settings.outcome_angle_deg,
            settings.outcome_joint_mrad / 1000.0,
        )


TOLERANCES = Tolerances()
_ROUNDING = 1.0001  # of a tolerance: figures are kept in whole steps
_ENDS = 5.0
"""How many times the tolerances the last rest may differ: an arm has arrived a little before."""
_OPENING = 0.1  # of a gripper's range
_WAY = 2.5  # how far a way may pass beside another, by the distance of its corners' lines from it
_PACE_S, _PACE_RATIO = 0.34, 1.1  # a time is another one that differs by more of both
_FIGURE_SHARE, _FIGURE_LEAST = 0.01, 0.002  # how far figures of a message may differ
_FIGURE = re.compile(r"(?<![\w'])-?(?:\d+\.\d+(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w'])")
_IN_A_ROW = 3


@dataclass(frozen=True, slots=True)
class OutcomeChanges:
    """How what a later run brought about differs from that of an earlier one, in sentences."""

    result: tuple[str, ...] = ()
    """What ends otherwise: objects, what is held, the cell, the last rest."""
    lost: tuple[str, ...] = ()
    """What of the earlier way the later one does not go."""
    added: tuple[str, ...] = ()
    """What the later way has beside all of the earlier one."""
    pace: tuple[str, ...] = ()
    """Which rests and ways take another time."""

    def __bool__(self) -> bool:
        return bool(self.result or self.lost or self.added or self.pace)

    @property
    def does_something_else(self) -> bool:
        """Whether the later mission is another one, or lacks some of the way."""
        return bool(self.result or self.lost)

    @property
    def of_mission(self) -> tuple[str, ...]:
        """All but the pace, the gravest first."""
        return (*self.result, *self.lost, *self.added)

    @property
    def sentences(self) -> tuple[str, ...]:
        """All of them, the gravest first."""
        return (*self.of_mission, *self.pace)


def outcome_changes(
    old: Outcome, new: Outcome, tolerances: Tolerances = TOLERANCES
) -> OutcomeChanges:
    """Return how what a later run brought about differs from that of an earlier one."""
    comparison = _Comparison(old, new, tolerances)
    joints = [tuple(arm.joints for arm in outcome.arms) for outcome in (old, new)]
    if joints[0] != joints[1] and all(joints):
        other = comparison.other_joints()
        return OutcomeChanges(result=(*comparison.objects(), *other, *comparison.cell()))
    lost, added = comparison.way()
    result = (*comparison.objects(), *comparison.cell(), *comparison.last_rest())
    kinds = (result, lost, added, comparison.pace())
    return OutcomeChanges(*(tuple(dict.fromkeys(sentences)) for sentences in kinds))


class _Comparison:
    """Two outcomes, their steps aligned."""

    def __init__(self, old: Outcome, new: Outcome, tolerances: Tolerances) -> None:
        self._old, self._new, self._tolerances = old, new, tolerances
        # Of a long run the first steps alone are kept, as many as there was room for.
        most = min(_whole_steps(old), _whole_steps(new))
        self._before, self._after = old.steps[:most], new.steps[:most]
        if not old.left_out and not new.left_out:
            self._before, self._after = old.steps, new.steps
        self._pairs = aligned(self._before, self._after, self._is_same)

    # The result

    def objects(self) -> list[str]:
        """Return what of the objects ends otherwise."""
        before = {found.name: found for found in self._old.objects}
        after = {found.name: found for found in self._new.objects}
        lines: list[str] = []
        for name in sorted({*before, *after}):
            if name not in after:
                lines.append(f"{name} is no longer in the scene")
            elif name not in before:
                lines.append(f"{name} is new in the scene")
            else:
                lines += self._object(before[name], after[name])
        return lines

    def _object(self, old: ObjectOutcome, new: ObjectOutcome) -> Iterator[str]:
        name, limits = old.name, self._tolerances
        if old.held_in != new.held_in:
            yield f"{name} ends {_held(new)}, before: {_held(old)}"
            return
        off = math.dist(old.end_m, new.end_m)
        tipped = abs(old.tilt_deg - new.tilt_deg)
        if off > limits.place_m * _ROUNDING:
            was_moved = math.dist(old.begin_m, old.end_m) > limits.place_m
            is_moved = math.dist(new.begin_m, new.end_m) > limits.place_m
            if was_moved and not is_moved:
                yield f"{name} is no longer moved"
                return
            elif is_moved and not was_moved:
                yield (
                    f"{name} is moved by {_mm(math.dist(new.begin_m, new.end_m))}, before: not "
                    "moved"
                )
            else:
                yield f"{name} ends {_mm(off)} from where it ended"
        if tipped > limits.angle_deg * _ROUNDING:
            yield f"{name} ends tilted by {new.tilt_deg:.0f} deg, before: {old.tilt_deg:.0f} deg"
        elif old.heading_deg is not None and new.heading_deg is not None and new.tilt_deg < 45.0:
            turned = abs((old.heading_deg - new.heading_deg + 180.0) % 360.0 - 180.0)
            if turned > limits.angle_deg * _ROUNDING:
                yield f"{name} ends turned by {turned:.0f} deg from how it ended"
        if old.rests_on != new.rests_on and off > limits.place_m * _ROUNDING:
            yield f"{name} ends on {new.rests_on or 'nothing'}, before: {old.rests_on or 'nothing'}"

    def cell(self) -> list[str]:
        """Return what was asked of the cell otherwise."""
        lines: list[str] = []
        before = {count.interface: count for count in self._old.cell_counts}
        after = {count.interface: count for count in self._new.cell_counts}
        for name in sorted({*before, *after} - {*self._old.streams, *self._new.streams}):
            lines += self._interface(before.get(name), after.get(name))
        for name in sorted({*self._old.streams} ^ {*self._new.streams}):
            was, now = (
                "at a steady rate"
                if name in outcome.streams
                else _times(counts[name].uses if name in counts else 0)
                for outcome, counts in ((self._old, before), (self._new, after))
            )
            lines.append(f"messages are sent on {name} {now}, before: {was}")
        return lines

    def _interface(self, before: CellCount | None, after: CellCount | None) -> Iterator[str]:
        known = after or before
        assert known is not None, "one of the runs used it"
        name, verb = known.interface, _VERBS[known.kind]
        was, now = (0 if count is None else count.uses for count in (before, after))
        if was != now or before is None or after is None:
            yield f"{name} {verb} {_times(now)}, before: {_times(was)}"
        elif before.succeeded != after.succeeded:
            yield f"{name} succeeds {_times(after.succeeded)}, before: {_times(before.succeeded)}"
        elif not self._old.left_out and not self._new.left_out:
            yield from self._contents(name)

    def _contents(self, name: str) -> Iterator[str]:
        gone = [use for use in self._old.cell if use.interface == name]
        come = []
        for use in (use for use in self._new.cell if use.interface == name):
            same = next((was for was in gone if _is_same_content(was.content, use.content)), None)
            if same is None:
                come.append(use)
            else:
                gone.remove(same)
        for was, use in zip(gone, come, strict=False):
            yield f"{name} gets {use.content or 'defaults'}, before: {was.content or 'defaults'}"

    def last_rest(self) -> list[str]:
        """Return where the arm ends otherwise."""
        lines = []
        for number in range(max(len(self._old.arms), len(self._new.arms))):
            before = [rest for rest in self._old.rests if rest.arm == number]
            after = [rest for rest in self._new.rests if rest.arm == number]
            if before and after and not self._is_same_rest(before[-1], after[-1], _ENDS):
                apart = self._apart(before[-1], after[-1])
                lines.append(f"{self._arm_name(number)} ends {apart} where it ended")
            elif before and not after:
                lines.append(f"{self._arm_name(number)} never comes to rest, before: it did")
        return lines

    def _arm_name(self, number: int) -> str:
        arms = self._old.arms or self._new.arms
        return "the arm" if len(arms) == 1 else f"the arm of {arms[number].joints[0]}"

    def other_joints(self) -> list[str]:
        """Return which joints are commanded only in one run."""
        before = {name for arm in self._old.arms for name in arm.joints}
        after = {name for arm in self._new.arms for name in arm.joints}
        lines = []
        if before - after:
            lines.append(f"never commanded any more: {', '.join(sorted(before - after))}")
        if after - before:
            lines.append(f"newly commanded: {', '.join(sorted(after - before))}")
        return lines or ["joints are grouped into arms differently"]

    # The way

    def way(self) -> tuple[list[str], list[str]]:
        """Return what of the way is lost, and what is added."""
        lost: list[str] = []
        added: list[str] = []
        for gone, come in self._gaps():
            rests = [step for step in gone if isinstance(step, Rest)]
            others = [step for step in come if isinstance(step, Rest)]
            for old, new in zip(rests, others, strict=False):
                lost.append(f"{self._rest_name(old)} is now {self._apart(old, new)} there")
            lost += self._lost_rests(rests[len(others) :])
            added += [f"a rest at {_place(new.tool_m)} is new" for new in others[len(rests) :]]
            lost += _grip_changes(gone, come, added)
        added += self._other_postures()
        lost += self._moved_uses()
        lost += self._other_ways()
        totals = [len(outcome.steps) + outcome.left_out for outcome in (self._old, self._new)]
        if (self._old.left_out or self._new.left_out) and totals[0] != totals[1]:
            line = f"the mission has {totals[1]} steps in all, before: {totals[0]}"
            (lost if totals[1] < totals[0] else added).append(line)
        return lost, added

    def _other_postures(self) -> Iterator[str]:
        """Yield rests at which the tool is where it was, and the arm is not."""
        found = []
        for i, j in self._pairs:
            old, new = self._before[i], self._after[j]
            if isinstance(old, Rest) and isinstance(new, Rest):
                turned = [abs(a - b) for a, b in zip(old.joints, new.joints, strict=True)]
                if max(turned) > self._tolerances.joint * _ROUNDING:
                    found.append((old, turned))
        if len(found) >= _IN_A_ROW:
            yield f"{len(found)} rests are reached in another posture of the arm"
            return
        for old, turned in found:
            worst = turned.index(max(turned))
            joint = self._old.arms[old.arm].joints[worst]
            yield (
                f"{self._rest_name(old)} is reached in another posture: {joint} is "
                f"{turned[worst]:.3f} {self._unit(old.arm, joint)} off"
            )

    def _unit(self, arm: int, joint: str) -> str:
        frames = self._old.arms[arm].frames
        return "m" if any(frame.slides for frame in frames if frame.joint == joint) else "rad"

    def _lost_rests(self, rests: Sequence[Rest]) -> Iterator[str]:
        """Yield rests in a row that are not reached, many of them in one sentence."""
        if len(rests) < _IN_A_ROW:
            yield from (f"{self._rest_name(rest)} is no longer reached" for rest in rests)
            return
        first, last = (self._number(rest) for rest in (rests[0], rests[-1]))
        total = sum(rest.arm == rests[0].arm for rest in self._old.rests)
        of = "" if self._old.left_out else f" of {total}"
        yield f"rests {first} to {last}{of} are no longer reached"

    def _gaps(self) -> Iterator[tuple[Sequence[Step], Sequence[Step]]]:
        """Yield the steps of both runs between those that are the same."""
        i = j = 0
        ends = [(len(self._before), len(self._after))]
        if self._old.left_out or self._new.left_out:
            ends = []  # what stands there in one run may be left out in the other
        for one, other in (*self._pairs, *ends):
            if one > i or other > j:
                yield self._before[i:one], self._after[j:other]
            i, j = one + 1, other + 1

    def _moved_uses(self) -> Iterator[str]:
        """Yield uses of the cell that come as often, and at another point of the mission."""
        kept_old = {i for i, _ in self._pairs}
        kept_new = {j for _, j in self._pairs}
        counts = [Counter(use.interface for use in uses.cell) for uses in (self._old, self._new)]
        for i, step in enumerate(self._before):
            if not isinstance(step, CellUse) or i in kept_old:
                continue
            place = next(
                (
                    j
                    for j, other in enumerate(self._after)
                    if j not in kept_new
                    and isinstance(other, CellUse)
                    and self._is_same(step, other)
                ),
                None,
            )
            if place is None or counts[0][step.interface] != counts[1][step.interface]:
                continue
            kept_new.add(place)
            now, was = _number_of_rests(self._after, place), _number_of_rests(self._before, i)
            yield (
                f"{step.interface} {_VERBS[step.kind]} {_after_rest(now)}, before: "
                f"{_after_rest(was)}"
                if now != was
                else f"{step.interface} {_VERBS[step.kind]} at another point after rest {now}"
            )

    def _other_ways(self) -> Iterator[str]:
        """Yield rests that are reached by another way of the tool, from the same rest."""
        corner_m = max(self._old.corner_m, self._new.corner_m)
        if not (self._old.corner_m and self._new.corner_m):
            return
        twin = {self._before[i].order: self._after[j].order for i, j in self._pairs}
        before, after = _rests_before(self._old), _rests_before(self._new)
        for i, j in self._pairs:
            old, new = self._before[i], self._after[j]
            if not isinstance(old, Rest) or not isinstance(new, Rest):
                continue
            left, now_left = before[old.order], after[new.order]
            if left is None or now_left is None or twin.get(left.order) != now_left.order:
                continue
            off = ways_apart(
                (left.tool_m, *old.via_m, old.tool_m), (left.tool_m, *new.via_m, old.tool_m)
            )
            if off > _WAY * corner_m:
                yield f"the way to {self._rest_name(old)} is up to {_mm(off)} away from the old one"

    def pace(self) -> list[str]:
        """Return which rests and ways take another time, between rests that are the same."""
        lines = []
        pairs = [(self._before[i], self._after[j]) for i, j in self._pairs]
        left_alike = True
        for place, (old, new) in enumerate(pairs):
            if not isinstance(old, Rest) or not isinstance(new, Rest):
                continue
            is_alike = self._is_alike(old, new, self._tolerances.joint)
            if is_alike and left_alike and _is_other_time(old.took_s, new.took_s):
                lines.append(
                    f"the way to {self._rest_name(old)} takes {new.took_s:.1f} s, before: "
                    f"{old.took_s:.1f} s"
                )
            is_last = place + 1 == len(pairs)
            if is_alike and not is_last and _is_other_time(old.held_s, new.held_s):
                lines.append(
                    f"the arm stays {new.held_s:.1f} s in {self._rest_name(old)}, before: "
                    f"{old.held_s:.1f} s"
                )
            left_alike = is_alike
        return lines

    # Steps

    def _is_same(self, old: Step, new: Step) -> bool:
        if isinstance(old, Rest) and isinstance(new, Rest):
            return self._is_same_rest(old, new)
        if isinstance(old, GripperUse) and isinstance(new, GripperUse):
            is_as_open = bool(old.holds) or abs(old.opened - new.opened) <= _OPENING
            return old.gripper == new.gripper and old.holds == new.holds and is_as_open
        if isinstance(old, CellUse) and isinstance(new, CellUse):
            is_alike = (old.kind, old.interface, old.succeeded) == (
                new.kind,
                new.interface,
                new.succeeded,
            )
            return is_alike and _is_same_content(old.content, new.content)
        return False

    def _is_same_rest(self, old: Rest, new: Rest, times: float = 1.0) -> bool:
        """Return whether the tool rests at the same place, within some times the tolerances."""
        if old.arm != new.arm or len(old.joints) != len(new.joints):
            return False
        limits = self._tolerances
        if self._is_alike(old, new, times * limits.joint):
            return True
        is_near = math.dist(old.tool_m, new.tool_m) <= times * limits.place_m * _ROUNDING
        turned = math.degrees(angle_between(old.tool_turn, new.tool_turn))
        return is_near and turned <= times * limits.angle_deg * _ROUNDING

    @staticmethod
    def _is_alike(old: Rest, new: Rest, limit: float) -> bool:
        joints = zip(old.joints, new.joints, strict=True)
        return all(abs(one - other) <= limit * _ROUNDING for one, other in joints)

    def _apart(self, old: Rest, new: Rest) -> str:
        off = math.dist(old.tool_m, new.tool_m)
        if off > self._tolerances.place_m * _ROUNDING:
            return f"{_mm(off)} from"
        turned = math.degrees(angle_between(old.tool_turn, new.tool_turn))
        return f"with the tool turned by {turned:.0f} deg from"

    def _rest_name(self, rest: Rest) -> str:
        total = sum(found.arm == rest.arm for found in self._old.rests)
        of = "" if self._old.left_out else f" of {total}"
        return f"rest {self._number(rest)}{of} at {_place(rest.tool_m)}"

    def _number(self, rest: Rest) -> int:
        rests = [found for found in self._old.rests if found.arm == rest.arm]
        return 1 + sum(found.order < rest.order for found in rests)


_VERBS = {"call": "is called", "message": "gets a message", "goal": "gets a goal"}


def _grip_changes(gone: Sequence[Step], come: Sequence[Step], added: list[str]) -> Iterator[str]:
    old = [step for step in gone if isinstance(step, GripperUse)]
    new = [step for step in come if isinstance(step, GripperUse)]
    for gripper in sorted({use.gripper for use in (*old, *new)}):
        before = [use for use in old if use.gripper == gripper]
        after = [use for use in new if use.gripper == gripper]
        for was, now in zip(before, after, strict=False):
            yield f"{gripper} {_grip(now)}, before: {_grip(was)}"
        for was in before[len(after) :]:
            yield f"{gripper} no longer {_grip(was)}"
        added += [f"{gripper} newly {_grip(now)}" for now in after[len(before) :]]


def _grip(use: GripperUse) -> str:
    if use.holds:
        return f"grips {use.holds}"
    if use.opened >= 1.0 - _OPENING:
        return "opens"
    if use.opened <= _OPENING:
        return "closes on nothing"
    return f"goes to {100.0 * use.opened:.0f} % of its opening"


def _whole_steps(outcome: Outcome) -> int:
    """Return how many steps are kept one after the other: behind those left out are last rests."""
    return len(outcome.steps) - (len(outcome.arms) if outcome.left_out else 0)


def _rests_before(outcome: Outcome) -> dict[int, Rest | None]:
    """Return the rest of the same arm before each rest, by the order of this."""
    found: dict[int, Rest | None] = {}
    last: dict[int, Rest] = {}
    for rest in outcome.rests:
        found[rest.order] = last.get(rest.arm)
        last[rest.arm] = rest
    return found


def _number_of_rests(steps: Sequence[Step], place: int) -> int:
    return sum(1 for step in steps[:place] if isinstance(step, Rest))


def _after_rest(number: int) -> str:
    return f"after rest {number}" if number else "before the first rest"


def _is_same_content(one: str, other: str) -> bool:
    """Return whether two contents say the same: whole numbers exactly, others within 1 %."""
    if one == other:
        return True
    if _FIGURE.sub("#", one) != _FIGURE.sub("#", other):
        return False
    figures = zip(_FIGURE.findall(one), _FIGURE.findall(other), strict=True)
    return all(
        math.isclose(float(a), float(b), rel_tol=_FIGURE_SHARE, abs_tol=_FIGURE_LEAST)
        for a, b in figures
    )


def _is_other_time(one: float, other: float) -> bool:
    return abs(one - other) > _PACE_S and max(one, other) > _PACE_RATIO * min(one, other)


def _held(found: ObjectOutcome) -> str:
    return f"held in {found.held_in}" if found.held_in else "free"


def _times(number: int) -> str:
    return {0: "never", 1: "once", 2: "twice"}.get(number, f"{number} times")


def _mm(length: float) -> str:
    return f"{1000.0 * length:.0f} mm"


def _place(place: Position) -> str:
    return f"({', '.join(f'{value:.3f}' for value in place)}) m"
