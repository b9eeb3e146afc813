"""Make the outcome of a run of what was recorded; docs/theory.md#what-a-run-brought-about."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import matrix_of
from tracerisk.common.outcome.arm import Arm, Position
from tracerisk.common.outcome.outcome import (
    CORNER_M,
    TICK_S,
    CellUse,
    GripperUse,
    ObjectOutcome,
    Outcome,
    Rest,
    Step,
    rest_of,
    rounded,
    rounded_position,
)
from tracerisk.common.outcome.ways import corners
from tracerisk.instrument.commands import Command
from tracerisk.instrument.recording import CELL
from tracerisk.pipeline.trace.recorded_run import Ran
from tracerisk.pipeline.trace.run_files import OBJECTS
from tracerisk.twin.physics.declared_log import read_declared
from tracerisk.twin.recording.contacts import RunContacts
from tracerisk.twin.recording.samples import POSE_EVERY, Samples
from tracerisk.twin.recording.tool_way import arm_of, tool_places
from tracerisk.twin.robots.gripper_ends import gripper_ends

_SAME_JOINT = 0.002  # a rest is another one whose joints differ by more [rad or m]
_SAME_OPENING = 0.05  # of a gripper's range
_AFTER_S = 1.0  # a grip shows no later than this after the gripper's command ended [s]
_BRAKED_S = 0.5  # an arm that was stopped stands still so much later [s]
_WAY_EVERY = 20  # steps between two looks at the tool's way

Array = NDArray[np.float64]


def run_outcome(ran: Ran, samples: Samples, contacts: RunContacts | None) -> Outcome:
    """Return what a run brought about."""
    maker = _Maker(ran, samples, contacts)
    note = ran.recording.note(CELL) or {"uses": (), "streams": ()}
    found: list[tuple[int, Step]] = [*maker.rests(), *maker.grips(), *_cell_uses(note["uses"])]
    timed = sorted(found, key=lambda step: step[0])
    steps = [replace(step, order=order) for order, (_, step) in enumerate(timed)]
    return Outcome(
        arms=maker.arms,
        objects=tuple(sorted(maker.objects(), key=lambda found: found.name)),
        rests=tuple(step for step in steps if isinstance(step, Rest)),
        grips=tuple(step for step in steps if isinstance(step, GripperUse)),
        cell=tuple(step for step in steps if isinstance(step, CellUse)),
        streams=tuple(note["streams"]),
    )


def _cell_uses(uses: Iterable[Sequence[Any]]) -> Iterator[tuple[int, CellUse]]:
    for time_ns, kind, interface, content, succeeded in uses:
        yield int(time_ns), CellUse(0, kind, interface, content, bool(succeeded))


@dataclass(frozen=True)
class _Maker:
    """Reads the parts of an outcome out of a run."""

    ran: Ran
    """The controller that has run, with robot and recording."""
    samples: Samples
    """The samples of the run."""
    contacts: RunContacts | None
    """The touches and holds of the run; `None` where contacts were not logged."""

    # The arms

    @cached_property
    def _arm_commands(self) -> list[Command]:
        arm = set(self._arm_joints)
        return [command for command in self.ran.recording.commands if arm & set(command.elements)]

    @cached_property
    def _arm_joints(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.ran.robot.arm_joints)

    @cached_property
    def arms(self) -> tuple[Arm, ...]:
        """Each arm that was commanded, with all joints between its base and its tool."""
        return tuple(arm_of(self.ran.robot, joints) for joints in self._commanded_together)

    @cached_property
    def _commanded_together(self) -> tuple[tuple[str, ...], ...]:
        joined: list[set[str]] = []
        for command in self._arm_commands:
            joints = {name for name in command.elements if name in self._arm_joints}
            if len(joints) == 1:
                # A joint with a topic of its own moves with those between it and the base.
                joints |= self._above(next(iter(joints)))
            apart = [known for known in joined if not known & joints]
            joined = [*apart, joints.union(*(known for known in joined if known & joints))]
        arms = [tuple(name for name in self._arm_joints if name in joints) for joints in joined]
        return tuple(sorted(arms, key=lambda arm: self._arm_joints.index(arm[0])))

    def _above(self, joint: str) -> set[str]:
        robot = self.ran.robot
        child = next(hung.child for hung in robot.attachments if hung.name == joint)
        return {hung.name for hung in robot.above(child) if hung.name in self._arm_joints}

    def rests(self) -> Iterator[tuple[int, Rest]]:
        """Yield each rest with its time [ns]."""
        for number, arm in enumerate(self.arms):
            yield from self._rests_of(number, arm)

    def _rests_of(self, number: int, arm: Arm) -> Iterator[tuple[int, Rest]]:
        own = [command for command in self._arm_commands if set(arm.joints) & set(command.elements)]
        last: Rest | None = None
        left_ns = 0
        reached = dict.fromkeys(arm.joints, 0.0)
        pairs: list[tuple[int, Rest]] = []
        for span in _busy_spans(own, self._end_ns):
            self._reach(reached, span)
            stood_s = rounded((span.next_ns - span.end_ns) / 1e9, TICK_S)
            took_s = rounded((span.end_ns - span.start_ns) / 1e9, TICK_S)
            rest = rest_of(
                arm,
                reached.values(),
                number=number,
                took_s=took_s,
                held_s=stood_s,
                via_m=self._via(arm, left_ns, span.end_ns),
                from_m=self._began_at(arm) if last is None else None,
            )
            left_ns = span.next_ns
            if last is not None and not rest.via_m and _is_same(rest.joints, last.joints):
                time_ns, before = pairs.pop()
                last = replace(before, held_s=rounded((span.next_ns - time_ns) / 1e9, TICK_S))
                pairs.append((time_ns, last))
                continue
            last = rest
            pairs.append((span.end_ns, last))
        yield from pairs

    def _reach(self, reached: dict[str, float], span: _Span) -> None:
        """Note where the commands of a span brought the joints: to their goals, or measured."""
        measured = self._all_at(self._settled_ns(span))
        reached.update({name: measured[name] for name in reached})
        for command in span.commands:
            if command.end == "arrived" and len(command.goal) == len(command.elements):
                goals = zip(command.elements, command.goal, strict=True)
                reached.update({name: goal for name, goal in goals if name in reached})

    @staticmethod
    def _settled_ns(span: _Span) -> int:
        if all(command.end == "arrived" for command in span.commands):
            return span.end_ns
        return min(span.next_ns, span.end_ns + round(_BRAKED_S * 1e9))

    def _via(self, arm: Arm, start_ns: int, end_ns: int) -> tuple[Position, ...]:
        first, last = self._step(start_ns), self._step(end_ns)
        if last - first < 2 * _WAY_EVERY:
            return ()
        way = self._tool_way(arm, np.append(np.arange(first, last, _WAY_EVERY), last))
        return tuple(rounded_position(corner) for corner in corners(way, CORNER_M))

    def _began_at(self, arm: Arm) -> Position:
        (place,) = self._tool_way(arm, np.array([0]))
        return rounded_position(place)

    def _tool_way(self, arm: Arm, rows: NDArray[np.int64]) -> list[Position]:
        columns = [self.samples.header.joints.index(name) for name in arm.joints]
        places = tool_places(arm, self.samples.position[rows][:, columns]).tolist()
        return [(x, y, z) for x, y, z in places]

    @cached_property
    def _end_ns(self) -> int:
        return self.samples.n_steps * self.samples.header.step_ns

    def _step(self, time_ns: int) -> int:
        return max(0, min(time_ns // self.samples.header.step_ns, self.samples.n_steps - 1))

    def _all_at(self, time_ns: int) -> dict[str, float]:
        names = self.samples.header.joints
        return dict(zip(names, self.samples.position[self._step(time_ns)].tolist(), strict=True))

    # The grippers

    def grips(self) -> Iterator[tuple[int, GripperUse]]:
        """Yield each use of a gripper with its time [ns]."""
        commands = self.ran.recording.commands
        for gripper in self.ran.robot.grippers:
            last: GripperUse | None = None
            ends = gripper_ends(self.ran.robot, gripper)
            for number, command in enumerate(commands):
                if gripper.name not in command.elements:
                    continue
                end_ns = self._end_ns if command.end_ns is None else command.end_ns
                later = (after for after in commands[number + 1 :] if after.issue_ns >= end_ns)
                next_ns = next((after.issue_ns for after in later), self._end_ns)
                holds = self._held_by(gripper.name, end_ns, next_ns, self._again_ns(number))
                opened = ends.share(gripper.position(self._all_at(end_ns)))
                use = GripperUse(0, gripper.name, rounded(opened, 0.01), holds)
                if last is not None and last.holds == holds and _is_as_open(last, use):
                    continue
                last = use
                yield end_ns, use

    def _again_ns(self, number: int) -> int:
        """Return when a gripper's next command was issued, or the run ended."""
        commands = self.ran.recording.commands
        own = set(commands[number].elements)
        later = (after for after in commands[number + 1 :] if own & set(after.elements))
        return next((after.issue_ns for after in later), self._end_ns)

    def _held_by(self, holder: str, end_ns: int, next_ns: int, again_ns: int) -> str:
        """Return what was held after a gripper's command, before the arm went on."""
        if self.contacts is None:
            return ""
        step_ns = self.samples.header.step_ns
        until = min(max(end_ns, next_ns) + round(_AFTER_S * 1e9), again_ns) // step_ns
        names = {
            self.contacts.log.bodies[hold.body].name
            for hold in self.contacts.holds
            if hold.holder == holder and hold.start <= until and hold.stop > end_ns // step_ns
        }
        return "+".join(sorted(names))

    # The objects

    def objects(self) -> Iterator[ObjectOutcome]:
        """Yield where each object that can be moved began and ended."""
        header, poses = self.samples.header, self.samples.poses
        known = set()
        if len(poses):
            ended = self.samples.end_pose if self.samples.end_pose is not None else poses[-1]
            for name, at in zip(header.free_bodies, header.free_at, strict=True):
                known.add(name)
                is_round = name in header.round_bodies
                yield self._object(name, poses[0, at : at + 7], ended[at : at + 7], is_round)
        for name, (begin, end) in self._declared().items():
            if name not in known:
                yield self._object(name, begin, end, is_round=False)

    def _declared(self) -> Mapping[str, tuple[Array, Array]]:
        """Return where each body that the controller declared was first, and last [m]."""
        pair: dict[str, tuple[Array, Array]] = {}
        moved: set[str] = set()
        for change in read_declared(self.ran.folder):
            free = [body.name for body in change.bodies if body.is_free]
            for body in change.bodies:
                end = np.array(body.pose)
                if body.is_free:
                    moved.add(body.name)
                    if len(change.poses):
                        end = change.poses[-1, free.index(body.name)]
                begin = pair[body.name][0] if body.name in pair else np.array(body.pose)
                pair[body.name] = begin, end
        # What was never attached is furniture.
        return {name: places for name, places in pair.items() if name in moved}

    def _object(self, name: str, begin: Array, end: Array, is_round: bool) -> ObjectOutcome:
        before, after = matrix_of(begin[3:].tolist()), matrix_of(end[3:].tolist())
        tilt = math.degrees(math.acos(min(max(float(after[2, 2]), -1.0), 1.0)))
        turn = after @ before.T
        heading = math.degrees(math.atan2(float(turn[1, 0]), float(turn[0, 0])))
        return ObjectOutcome(
            name=name,
            begin_m=rounded_position(begin[:3]),
            end_m=rounded_position(end[:3]),
            tilt_deg=rounded(tilt, 1.0),
            heading_deg=None if is_round else rounded(heading, 1.0),
            rests_on=self._bearing(name),
            held_in=self._holding(name),
        )

    def _holding(self, name: str) -> str:
        if self.contacts is None:
            return ""
        last = self.samples.n_steps - 1
        holders = {
            hold.holder
            for hold in self.contacts.holds
            if self.contacts.log.bodies[hold.body].name == name and hold.stop > last - POSE_EVERY
        }
        return "+".join(sorted(holders))

    def _bearing(self, name: str) -> str:
        note = self.ran.recording.note(OBJECTS) or {}
        return "+".join(note.get("bearing", {}).get(name, ()))


def _is_as_open(one: GripperUse, other: GripperUse) -> bool:
    return bool(one.holds) or abs(one.opened - other.opened) <= _SAME_OPENING


def _is_same(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(a - b) <= _SAME_JOINT for a, b in zip(one, other, strict=True))


@dataclass(frozen=True)
class _Span:
    """A time in which an arm was under way without a stop, in simulated time."""

    start_ns: int
    """When its first command was issued [ns]."""
    end_ns: int
    """When its last command ended [ns]."""
    next_ns: int
    """When the next one began, or the run ended."""
    commands: tuple[Command, ...]
    """The commands of the time, in the order of issue."""


def _busy_spans(commands: Sequence[Command], end_ns: int) -> Iterator[_Span]:
    """Yield the times in which an arm was under way: commands that overlap, or replace others."""
    spans: list[tuple[int, int, list[Command]]] = []
    for command in sorted(commands, key=lambda found: (found.issue_ns, found.id)):
        stop_ns = end_ns if command.end_ns is None else command.end_ns
        if spans and _goes_on(spans[-1], command):
            start_ns, before_ns, known = spans[-1]
            spans[-1] = start_ns, max(before_ns, stop_ns), [*known, command]
        else:
            spans.append((command.issue_ns, stop_ns, [command]))
    for index, (start_ns, stop_ns, known) in enumerate(spans):
        next_ns = spans[index + 1][0] if index + 1 < len(spans) else max(end_ns, stop_ns)
        yield _Span(start_ns, stop_ns, next_ns, tuple(known))


def _goes_on(span: tuple[int, int, list[Command]], command: Command) -> bool:
    _, stop_ns, known = span
    if command.issue_ns < stop_ns:
        return True
    # One that took over at the instant at which the other was cut.
    return command.issue_ns == stop_ns and known[-1].end == "replaced"
