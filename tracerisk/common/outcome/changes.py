"""Compare what two runs brought about: result, way and pace, in sentences.

The result is where objects end, what is held, what the cell was asked for and the last rest. The
way are rests, gripper uses and the order of all steps, aligned as sequences are. The pace, how long
the arm rests and moves, is named and decides nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from tracerisk.common.outcome.alignment import aligned
from tracerisk.common.outcome.moved_rests import MovedRest, moved_together, rest_name
from tracerisk.common.outcome.outcome import CellUse, GripperUse, Outcome, Rest, Step
from tracerisk.common.outcome.result_changes import (
    VERBS,
    cell_changes,
    millimetres,
    newly_moved,
    not_set_down,
    object_changes,
)
from tracerisk.common.outcome.step_words import (
    _IN_A_ROW,
    after_rest,
    grip,
    is_other_time,
    new_rests,
    number_of_rests,
    oftener,
    rests_before,
    whole_steps,
)
from tracerisk.common.outcome.tolerances import ROUNDING, TOLERANCES, Tolerances
from tracerisk.common.outcome.ways import ways_apart

_ENDS = 5.0
"""How many times the tolerances the last rest may differ: an arm has arrived a little before."""
_WAY = 2.5  # how far a way may pass beside another, by the distance of its corners' lines from it


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
    is_other_way: bool = False
    """Whether `lost` is only rests that are elsewhere now, and other ways between rests."""
    newly_moved: tuple[str, ...] = ()
    """The names of objects that only the later run moves."""
    arm_s: tuple[float | None, float | None] = (None, None)
    """How long the arm is under way before and after [s], as `Outcome.under_way_s`."""

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
    objects, cell = object_changes(old, new, tolerances), cell_changes(old, new)
    moved = newly_moved(old, new, tolerances)
    joints = [tuple(arm.joints for arm in outcome.arms) for outcome in (old, new)]
    if joints[0] != joints[1] and all(joints):
        other = comparison.other_joints()
        return OutcomeChanges(result=(*objects, *other, *cell), newly_moved=moved)
    lost, added = comparison.way()
    result = (*objects, *cell, *comparison.last_rest())
    kinds = (result, lost, added, comparison.pace())
    ends, gone, come, pace = (tuple(dict.fromkeys(sentences)) for sentences in kinds)
    is_other = bool(lost) and set(lost) <= comparison.other_places()
    times = old.under_way_s, new.under_way_s
    return OutcomeChanges(ends, gone, come, pace, is_other, newly_moved=moved, arm_s=times)


@dataclass(frozen=True, slots=True)
class AlignedSteps:
    """Steps of two runs that stand at the same place of both ways."""

    before: tuple[Step, ...]
    """Those of the earlier run; empty where only the later one has any."""
    after: tuple[Step, ...]
    """Those of the later run; empty where only the earlier one has any."""
    words: tuple[str, ...] = ()
    """What differs there, in sentences; empty where both do the same."""


def aligned_steps(
    old: Outcome, new: Outcome, tolerances: Tolerances = TOLERANCES
) -> tuple[AlignedSteps, ...]:
    """Return the ways of two runs in order: a step that both have, or what stands between two.

    Nothing is returned for runs that command other joints.
    """
    joints = [tuple(arm.joints for arm in outcome.arms) for outcome in (old, new)]
    return () if joints[0] != joints[1] else tuple(_Comparison(old, new, tolerances).in_step())


class _Comparison:
    """Two outcomes, their steps aligned."""

    def __init__(self, old: Outcome, new: Outcome, tolerances: Tolerances) -> None:
        self._old, self._new, self._tolerances = old, new, tolerances
        # Of a long run the first steps alone are kept, as many as there was room for.
        most = min(whole_steps(old), whole_steps(new))
        self._before, self._after = old.steps[:most], new.steps[:most]
        if not old.left_out and not new.left_out:
            self._before, self._after = old.steps, new.steps
        self._pairs = aligned(self._before, self._after, tolerances.is_same)

    # The result

    def last_rest(self) -> list[str]:
        """Return where the arm ends otherwise."""
        lines = []
        for number in range(max(len(self._old.arms), len(self._new.arms))):
            if number in self._moved_ends:
                lines.append(f"{self._arm_name(number)} {self._moved_ends[number].end_words}")
            elif self._old.rests_of(number) and not self._new.rests_of(number):
                lines.append(f"{self._arm_name(number)} never comes to rest, before: it did")
        return lines

    @cached_property
    def _moved_ends(self) -> dict[int, MovedRest]:
        """The last rest of each arm that ends elsewhere, by the arm's number."""
        ends = {}
        for number in range(len(self._old.arms)):
            before, after = (outcome.rests_of(number) for outcome in (self._old, self._new))
            if before and after and not self._tolerances.is_same_rest(before[-1], after[-1], _ENDS):
                ends[number] = self._moved(before[-1], after[-1])
        return ends

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
            self._gap(gone, come, lost, added)
        told = {moved_rest.words for moved_rest in self._moved_ends.values()}
        lost = [self._moved_together.get(words, words) for words in lost if words not in told]
        lost = [*not_set_down(self._old, self._new), *lost] if lost else lost
        added += self._other_postures()
        lost += self._moved_uses()
        lost += self._other_ways.values()
        totals = [len(outcome.steps) + outcome.left_out for outcome in (self._old, self._new)]
        if (self._old.left_out or self._new.left_out) and totals[0] != totals[1]:
            line = f"the mission has {totals[1]} steps in all, before: {totals[0]}"
            (lost if totals[1] < totals[0] else added).append(line)
        return lost, added

    def _gap(
        self, gone: Sequence[Step], come: Sequence[Step], lost: list[str], added: list[str]
    ) -> None:
        """Add what is lost and what is added between two steps that are the same."""
        rests = [step for step in gone if isinstance(step, Rest)]
        others = [step for step in come if isinstance(step, Rest)]
        lost += [moved_rest.words for moved_rest in self._moved_rests(gone, come)]
        lost += self._lost_rests(rests[len(others) :])
        added += new_rests(others[len(rests) :])
        lost += self._grip_changes(gone, come, added)

    def _moved_rests(self, gone: Sequence[Step], come: Sequence[Step]) -> Iterator[MovedRest]:
        """Yield the rests between two steps that are the same which are elsewhere now."""
        rests, others = (
            [step for step in steps if isinstance(step, Rest)] for steps in (gone, come)
        )
        for old, new in zip(rests, others, strict=False):
            yield self._moved(old, new)

    def _moved(self, old: Rest, new: Rest) -> MovedRest:
        return MovedRest(self._number(old), self._total(old), old, new, self._tolerances)

    @cached_property
    def _moved_together(self) -> dict[str, str]:
        """For the words of each rest that is elsewhere now the sentence that says it of many."""
        gaps = self._gaps()
        return moved_together([rest for gap in gaps for rest in self._moved_rests(*gap)])

    def other_places(self) -> set[str]:
        """Return which rests are elsewhere now, and are reached by another way."""
        return {*self._other_ways.values(), *self._moved_together.values()}

    def in_step(self) -> Iterator[AlignedSteps]:
        """Yield the steps that are the same, and those between them, in order."""
        for gone, come, is_same in self._stretches():
            if is_same:
                way = self._other_ways.get(gone[0].order)
                yield AlignedSteps(gone, come, (way,) if way else ())
            else:
                lost: list[str] = []
                added: list[str] = []
                self._gap(gone, come, lost, added)
                yield AlignedSteps(gone, come, tuple(dict.fromkeys((*lost, *added))))

    def _other_postures(self) -> Iterator[str]:
        """Yield rests at which the tool is where it was, and the arm is not."""
        pairs = []
        for i, j in self._pairs:
            old, new = self._before[i], self._after[j]
            if isinstance(old, Rest) and isinstance(new, Rest):
                turned = [abs(a - b) for a, b in zip(old.joints, new.joints, strict=True)]
                if max(turned) > self._tolerances.joint * ROUNDING:
                    pairs.append((old, turned))
        if len(pairs) >= _IN_A_ROW:
            yield f"{len(pairs)} rests are reached in another posture of the arm"
            return
        for old, turned in pairs:
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
        total = self._total(rests[0])
        of = f" of {total}" if total else ""
        yield f"rests {first} to {last}{of} are no longer reached"

    def _stretches(self) -> Iterator[tuple[tuple[Step, ...], tuple[Step, ...], bool]]:
        """Yield the steps of both runs in order: two that are the same, or those between such."""
        i = j = 0
        for one, other in (*self._pairs, (len(self._before), len(self._after))):
            if one > i or other > j:
                yield self._before[i:one], self._after[j:other], False
            if one < len(self._before):
                yield self._before[one : one + 1], self._after[other : other + 1], True
            i, j = one + 1, other + 1

    def _gaps(self) -> Iterator[tuple[Sequence[Step], Sequence[Step]]]:
        """Yield the steps of both runs between those that are the same."""
        gaps = list(self._stretches())
        if gaps and not gaps[-1][2] and (self._old.left_out or self._new.left_out):
            del gaps[-1]  # what stands there in one run may be left out in the other
        yield from ((gone, come) for gone, come, is_same in gaps if not is_same)

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
                    and self._tolerances.is_same(step, other)
                ),
                None,
            )
            if place is None or counts[0][step.interface] != counts[1][step.interface]:
                continue
            kept_new.add(place)
            now, was = number_of_rests(self._after, place), number_of_rests(self._before, i)
            yield (
                f"{step.interface} {VERBS[step.kind]} {after_rest(now)}, before: {after_rest(was)}"
                if now != was
                else f"{step.interface} {VERBS[step.kind]} at another point after rest {now}"
            )

    @cached_property
    def _other_ways(self) -> dict[int, str]:
        """Rests that are reached by another way of the tool, by their order.

        Both ways lead from the same rest, or from where the runs began.
        """
        ways: dict[int, str] = {}
        corner_m = max(self._old.corner_m, self._new.corner_m)
        if not (self._old.corner_m and self._new.corner_m):
            return ways
        twin = {self._before[i].order: self._after[j].order for i, j in self._pairs}
        before, after = rests_before(self._old), rests_before(self._new)
        for i, j in self._pairs:
            old, new = self._before[i], self._after[j]
            if not isinstance(old, Rest) or not isinstance(new, Rest):
                continue
            left, now_left = before[old.order], after[new.order]
            if left is not None and now_left is not None:
                if twin.get(left.order) != now_left.order:
                    continue
                begin = now_begin = left.tool_m
            elif left is None and now_left is None and old.from_m and new.from_m:
                begin, now_begin = old.from_m, new.from_m
            else:
                continue
            off = ways_apart((begin, *old.via_m, old.tool_m), (now_begin, *new.via_m, old.tool_m))
            if off > _WAY * corner_m:
                name = self._rest_name(old)
                ways[old.order] = (
                    f"the way to {name} is up to {millimetres(off)} away from the old one"
                )
        return ways

    def pace(self) -> list[str]:
        """Return which rests and ways take another time, between rests that are the same."""
        lines = []
        pairs = [(self._before[i], self._after[j]) for i, j in self._pairs]
        left_alike = True
        for place, (old, new) in enumerate(pairs):
            if not isinstance(old, Rest) or not isinstance(new, Rest):
                continue
            is_alike = self._tolerances.is_same_posture(old, new)
            if is_alike and left_alike and is_other_time(old.took_s, new.took_s):
                lines.append(
                    f"the way to {self._rest_name(old)} takes {new.took_s:.1f} s, before: "
                    f"{old.took_s:.1f} s"
                )
            is_last = place + 1 == len(pairs)
            if is_alike and not is_last and is_other_time(old.held_s, new.held_s):
                lines.append(
                    f"the arm stays {new.held_s:.1f} s in {self._rest_name(old)}, before: "
                    f"{old.held_s:.1f} s"
                )
            left_alike = is_alike
        return lines

    # Words

    def _rest_name(self, rest: Rest) -> str:
        return rest_name(self._number(rest), self._total(rest), rest)

    def _total(self, rest: Rest) -> int:
        """Return how many rests of an arm there are; 0 where not all are kept."""
        return 0 if self._old.left_out else len(self._old.rests_of(rest.arm))

    def _grip_changes(
        self, gone: Sequence[Step], come: Sequence[Step], added: list[str]
    ) -> Iterator[str]:
        """Yield which uses of a gripper are lost or other ones, and add those that are new."""
        old = [step for step in gone if isinstance(step, GripperUse)]
        new = [step for step in come if isinstance(step, GripperUse)]
        for gripper in sorted({use.gripper for use in (*old, *new)}):
            before = [use for use in old if use.gripper == gripper]
            after = [use for use in new if use.gripper == gripper]
            for was, now in zip(before, after, strict=False):
                yield f"{gripper} {grip(now)}, before: {grip(was)}"
            for was in before[len(after) :]:
                less = oftener(was, self._old, self._new, "less")
                yield less or f"{gripper} no longer {grip(was)}"
            for now in after[len(before) :]:
                more = oftener(now, self._new, self._old, "more")
                added.append(more or f"{gripper} newly {grip(now)}")

    def _number(self, rest: Rest) -> int:
        return 1 + sum(same.order < rest.order for same in self._old.rests_of(rest.arm))
