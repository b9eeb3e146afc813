"""What moves the joints: the live motions, their set-points, and who takes over from whom."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.motion.execution import (
    ArmTrack,
    GoalTolerance,
    Motion,
    TimedWay,
    Track,
    check_trajectory,
)
from tracerisk.twin.motion.gripper_track import GripperTrack
from tracerisk.twin.motion.interpolation import resample
from tracerisk.twin.physics.motion import STEP_S, JointTrajectory, MotionOutcome, PlanningError
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper
from tracerisk.twin.simulation.simulation import Simulation

_FINGER_SLACK = 1e-4  # a finger's goal this far past its range is a rounding error [m]

Array = NDArray[np.float64]


class MotionControl:
    """The motions of a simulated robot; it gives the set-points of every step."""

    def __init__(self, robot: Robot, simulation: Simulation) -> None:
        self._robot = robot
        self._simulation = simulation
        self._tracks: list[Track] = []
        self._set_points = simulation.controls()
        self._has_moved = False

    @property
    def busy(self) -> bool:
        """Whether a motion is live."""
        return any(track.motion is not None for track in self._tracks)

    def begin_at(self, positions: Mapping[str, float]) -> bool:
        """Put joints of the arm where they begin [rad or m]; False after the first motion."""
        if self._has_moved or not set(positions) <= {one.name for one in self._robot.arm_joints}:
            return False
        self._simulation.place(positions)
        self._set_points = self._simulation.controls()
        return True

    def steps_ahead(self, wanted: int) -> int:
        """Return for how many of the `wanted` steps the set-points are known."""
        return min((track.steps_ahead() for track in self._tracks), default=wanted)

    def set_points(self, count: int) -> Array:
        """Return the set-points of the next `count` steps, (count, n_actuators)."""
        block = np.repeat(self._set_points[None, :], count, axis=0)
        for track in self._tracks:
            track.fill(block, self._simulation)
        self._set_points = block[-1]
        return block

    def settle(self) -> bool:
        """Drop the tracks that are over; say whether a motion ended with one of them."""
        if not self._tracks or self._simulation.faults.has_lost_link:
            return False  # whether one is over, nobody hears
        ended = False
        kept: list[Track] = []
        for track in self._tracks:
            if not track.finished(self._simulation, self._simulation.time_ns):
                kept.append(track)
                continue
            motion = track.motion
            if motion is not None and motion.outcome != "active":
                ended = True
                if motion.outcome == "aborted":
                    self._hold(track)
        self._tracks = kept
        return ended

    def follow(
        self, trajectory: JointTrajectory, *, goal_tolerance: GoalTolerance | None = None
    ) -> Motion:
        """Follow a trajectory; a live motion on any of its joints is preempted.

        A first point later than time 0 is reached from the present set-point.
        Fingers go through its points too, no faster and no further than they can.
        Raises PlanningError("bad_request") for a trajectory that is none.
        """
        check_trajectory(trajectory, self._robot)
        trajectory = self._led_in(trajectory)
        goal = dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))
        ways = [(item, self._way_of(item, trajectory)) for item in self._grippers_in(trajectory)]
        goal.update({gripper.name: float(way[1][-1, 0]) for gripper, way in ways})
        elements = self._elements_of(trajectory.joints)
        motion = Motion(
            trajectory.joints,
            elements,
            self._simulation.time_ns,
            tuple(goal[name] for name in elements),
            trajectory.leads,
        )
        if motion.leads == "on":
            fastest = np.abs(trajectory.velocity).argmax(axis=0)
            motion.speeds = tuple(np.take_along_axis(trajectory.velocity, fastest[None], 0)[0])
        self._end("preempted", "preempted", motion.elements, by=motion)
        # A gripper may be called as its only finger is, which has no servo of its own.
        arm = {joint.name for joint in self._robot.arm_joints}
        columns = [i for i, name in enumerate(trajectory.joints) if name in arm]
        if columns:
            names = [trajectory.joints[i] for i in columns]
            position, velocity = trajectory.position[:, columns], trajectory.velocity[:, columns]
            bend = trajectory.acceleration
            shape = (trajectory.degree, None if bend is None else bend[:, columns])
            track = ArmTrack(
                motion,
                [self._simulation.actuator[name] for name in names],
                [self._simulation.joint_index[name] for name in names],
                [self._robot.joint(name) for name in names],
                *resample(trajectory.time, position, velocity, STEP_S, *shape),
                self._simulation.position([self._simulation.joint_index[name] for name in names]),
                goal_tolerance or GoalTolerance(),
            )
            self._add(track)
        for gripper, way in ways:
            target = float(way[1][-1, 0])
            self._add(self._gripper_track(motion, gripper, target, None, way))
        return motion

    def move_gripper(
        self, gripper: str, position: float, *, max_effort: float | None = None
    ) -> Motion:
        """Move the fingers to `position` [m] each, with at most `max_effort` [N] each.

        The motion succeeds when they are there, or stand still on something before.
        Raises PlanningError("invalid_goal") for a position or an effort that is not allowed.
        """
        result = self._robot.gripper(gripper)
        motion = Motion(result.joints, (result.name,), self._simulation.time_ns, (position,))
        track = self._gripper_track(motion, result, position, max_effort)
        self._end("preempted", "preempted", motion.elements, by=motion)
        self._add(track)
        return motion

    def stop(self, joints: Iterable[str] | None = None) -> None:
        """Preempt the motions of these joints (of all), and bring them to rest.

        Raises RobotError for a joint that there is not.
        """
        names = tuple(self._simulation.joint_index) if joints is None else tuple(joints)
        for name in names:
            if name not in self._simulation.joint_index:
                raise RobotError(
                    f"robot '{self._robot.name}' has no joint '{name}'; "
                    f"{one_of(self._simulation.joint_index, name)}"
                )
        self._end("preempted", "preempted", self._elements_of(names))

    def abort(self, motion: Motion, message: str) -> None:
        """End a motion as failed, for a reason of its owner's, and bring its joints to rest."""
        if motion.outcome == "active":
            self._end("aborted", message, motion.elements)

    def references(self) -> tuple[Array, Array]:
        """Return the set-points of all joints and their velocities; of fingers, as measured."""
        position = self._simulation.position().copy()
        velocity = np.zeros(len(position))
        for joint in self._robot.arm_joints:
            position[self._simulation.joint_index[joint.name]] = self._set_points[
                self._simulation.actuator[joint.name]
            ]
        for track in self._tracks:
            if isinstance(track, ArmTrack):
                position[track.joints], velocity[track.joints] = track.reference()
        return position, velocity

    def references_ahead(self, joints: Sequence[str], n_steps: int) -> tuple[Array, Array]:
        """Return the set-points of joints in the next steps, if nothing else is commanded.

        Positions and velocities, each (n_steps, n_joints).
        """
        position, _ = self.references()
        places = [self._simulation.joint_index[name] for name in joints]
        positions = np.repeat(position[places][None, :], n_steps, axis=0)
        velocities = np.zeros_like(positions)
        for track in self._tracks:
            if isinstance(track, ArmTrack):
                ahead = track.ahead(n_steps)
                for own, place in enumerate(track.joints):
                    if place in places:
                        column = places.index(place)
                        positions[:, column] = ahead[0][:, own]
                        velocities[:, column] = ahead[1][:, own]
        return positions, velocities

    def reference(self, joints: Iterable[str]) -> tuple[Array, Array]:
        """Return the set-points of some joints and their velocities, as `references` of all."""
        position, velocity = self.references()
        columns = [self._simulation.joint_index[name] for name in joints]
        return position[columns], velocity[columns]

    def _hold(self, track: Track) -> None:
        """Take what is measured for the set-point: an arm that is blocked stops pressing."""
        if isinstance(track, ArmTrack):
            self._set_points = self._set_points.copy()
            self._set_points[track.actuators] = self._simulation.position(track.joints)

    def _end(
        self,
        outcome: MotionOutcome,
        message: str,
        elements: Iterable[str],
        *,
        by: Motion | None = None,
    ) -> None:
        """End the motions that address any of the elements; their arm joints brake.

        `by` is the motion that takes these elements.
        """
        wanted = set(elements)
        for track in [track for track in self._tracks if track.motion is not None]:
            motion = track.motion
            if motion is None or not wanted & set(motion.elements):
                continue
            self._tracks.remove(track)
            if motion.outcome == "active":
                motion.replaced_by = by
            way = track.way(self._simulation)
            motion.end_part(outcome, message, self._simulation.time_ns, way)
            if isinstance(track, ArmTrack):
                self._tracks.append(track.brake())

    def _add(self, track: Track) -> None:
        """Begin a track; where its actuators were still braking, it leads on from there."""
        self._has_moved = True
        taken = set(track.actuators)
        self._tracks = [
            kept
            for other in self._tracks
            if (kept := other.without(taken) if isinstance(other, ArmTrack) else other) is not None
        ]
        if track.motion is not None:
            track.motion.begin_part()
        self._tracks.append(track)

    def _gripper_track(
        self,
        motion: Motion,
        gripper: Gripper,
        position: float,
        max_effort: float | None,
        timed: TimedWay | None = None,
    ) -> GripperTrack:
        effort = gripper.effort if max_effort is None else max_effort
        if not 0.0 < effort < math.inf:
            raise PlanningError(
                "invalid_goal", f"effort {effort:g} N of '{gripper.name}'; give more than 0"
            )
        if not gripper.least - _FINGER_SLACK <= position <= gripper.opening + _FINGER_SLACK:
            raise PlanningError(
                "invalid_goal",
                f"position {position:g} of '{gripper.name}' is outside "
                f"[{gripper.least:g}, {gripper.opening:g}] for each finger",
            )
        joints = [self._simulation.joint_index[name] for name in gripper.joints]
        return GripperTrack(
            motion,
            gripper,
            [self._robot.joint(name) for name in gripper.joints],
            self._simulation.actuator[gripper.name],
            joints,
            begin=gripper.position(self._positions()),
            target=min(max(position, gripper.least), gripper.opening),
            max_effort=min(effort, gripper.effort),
            timed=timed,
        )

    def _grippers_in(self, trajectory: JointTrajectory) -> Iterator[Gripper]:
        names = set(trajectory.joints)
        yield from (gripper for gripper in self._robot.grippers if names & set(gripper.joints))

    def _way_of(self, gripper: Gripper, trajectory: JointTrajectory) -> TimedWay:
        """Return the way of a gripper in a trajectory of some of its joints: that of its leader."""
        last = dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))
        leader = gripper.leader(last, gripper.position(self._positions()))
        column, sign = [trajectory.joints.index(leader)], gripper.sign(leader)
        position = sign * trajectory.position[:, column]
        # A controller of trajectories knows no limits: the fingers stop at theirs.
        reached = np.clip(position, gripper.least, gripper.opening)
        velocity = np.where(reached == position, sign * trajectory.velocity[:, column], 0.0)
        return trajectory.time, reached, velocity

    def _led_in(self, trajectory: JointTrajectory) -> JointTrajectory:
        """Return the trajectory, begun at the present set-points where it begins later."""
        if trajectory.time[0] <= 0.0:
            return trajectory
        return trajectory.led_in(*self.reference(trajectory.joints))

    def _elements_of(self, joints: Iterable[str]) -> tuple[str, ...]:
        owner = {name: g.name for g in self._robot.grippers for name in g.joints}
        return tuple(dict.fromkeys(owner.get(name, name) for name in joints))

    def _positions(self) -> dict[str, float]:
        measured = self._simulation.position().tolist()
        return dict(zip(self._simulation.joint_index, measured, strict=True))
