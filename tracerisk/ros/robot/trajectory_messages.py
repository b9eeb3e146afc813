"""Trajectories as controllers send them, checked as a trajectory controller checks them."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.instrument.recording import NEAR
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.trajectories.joint_names import JointNames
from tracerisk.ros.robot.trajectories.robot_spaces import RobotSpaces
from tracerisk.ros.robot.trajectories.trajectory_rules import (
    TrajectoryRules,
    stopped_positions,
    within_limits,
)
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.physics.motion import JointTrajectory

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.simulation.twin import Twin

    Stack = tuple[Frame, ...] | None

Array = NDArray[np.float64]

_S = 1e-9
_PRESSED = 0.002  # as far past its limit a finger may be measured [m or rad]
START_TOLERANCE = 0.01
"""How far a trajectory may begin from where the set-points are [rad or m]."""


class TrajectoryCode(enum.IntEnum):
    """The values of `error_code` in control_msgs/FollowJointTrajectory."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class TrajectoryRefusedError(Exception):
    """A trajectory that no controller would follow: the reason, its `code`, and if it is past."""

    def __init__(
        self,
        message: str,
        code: TrajectoryCode = TrajectoryCode.INVALID_GOAL,
        *,
        is_late: bool = False,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.is_late = is_late


class TrajectoryNode(TwinNode):
    """What takes trajectories of a controller: its words for what they move, and for what not."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._names = runtime.client(JointNames)
        self._rules = runtime.client(TrajectoryRules)
        self._spaces = runtime.client(RobotSpaces)

    @property
    def _is_drivers(self) -> bool:
        """Whether a maker's driver takes them: it has its own names of joints, or own rules."""
        return self._rules.has_own or bool(self._names.of_joints)

    def _report_unmoved(self, what: str, names: Sequence[str], stack: Stack = None) -> None:
        """Report names for which a driver has a note instead of joints."""
        for name, note in self._names.notes(names).items():
            words = f"'{name}' of {what} moved nothing: {note}"
            self._commands.report("unprovided", words, stack, object_name=name)

    def _note_space(self, topic: str, joints: Sequence[str], stack: Stack = None) -> None:
        if words := self._spaces.other(topic, joints):
            self._commands.report("one_robot", words, stack, object_name=topic)

    def _stopped(self, what: str, asked: JointTrajectory, stack: Stack = None) -> JointTrajectory:
        """Return a trajectory as the driver takes it, which may stop joints at their limits.

        Fingers stop at theirs, whoever takes it.
        """
        robot = self._twin.robot
        if self._rules.stop_at_limits:
            trajectory, past = within_limits(asked, robot)
        else:
            fingers = {name for gripper in robot.grippers for name in gripper.joints}
            _, beyond = within_limits(asked, robot, _PRESSED)
            trajectory = asked
            past = {joint: words for joint, words in beyond.items() if joint in fingers}
            self._look_on_the_way(what, asked, fingers, stack)
        for joint, words in past.items():
            taken = f"{what} takes joint '{joint}' {words}"
            self._commands.report("stopped_at_limit", taken, stack, object_name=joint)
        return trajectory

    def _look_on_the_way(
        self, what: str, asked: JointTrajectory, fingers: set[str], stack: Stack
    ) -> None:
        """Report joints that are past their limits before the last point, and not in it.

        The last point is the goal of the command, whose end says what became of it.
        """
        robot = self._twin.robot
        _, past = stopped_positions(asked.joints, asked.position, robot, NEAR)
        _, ends = stopped_positions(asked.joints, asked.position[-1:], robot, NEAR)
        for joint, words in past.items():
            if joint not in fingers and joint not in ends:
                taken = f"{what} takes joint '{joint}' on its way {words}"
                self._commands.report("past_limit", taken, stack, object_name=joint)


def of_its_joints(message: Any) -> Any:
    """Return a trajectory whose points have a value for each joint that it names, and no more.

    Drivers of ROS-Industrial pick the values of their joints by name, and look at no others.
    """
    cut = copy(message)
    count, cut.points = len(message.joint_names), [copy(point) for point in message.points]
    for point in cut.points:
        for name in ("positions", "velocities", "accelerations"):
            setattr(point, name, list(getattr(point, name))[:count])
    return cut


def twin_trajectory(message: Any, twin: Twin, now_ns: int) -> JointTrajectory:
    """Return what a trajectory_msgs/JointTrajectory of either ROS asks of the twin from now on.

    A header without a time means at once; points that lie in the past are dropped, and a first
    point that is not where the joints are is reached from there.
    Where points give no velocities, the joints pass them on a curve that does not overshoot.

    Raises:
        TrajectoryRefusedError: unknown joints, ill-formed points, or all of them in the past.
    """
    names = tuple(message.joint_names)
    _check_joints(names, twin)
    points = list(message.points)
    if not points:
        raise TrajectoryRefusedError("the trajectory has no points")
    for index, point in enumerate(points):
        if len(point.positions) != len(names):
            raise TrajectoryRefusedError(
                f"point {index} has {len(point.positions)} positions for {len(names)} joints",
            )
        if len(point.velocities) not in (0, len(names)):
            raise TrajectoryRefusedError(
                f"point {index} has {len(point.velocities)} velocities for {len(names)} joints",
            )
    time = np.array([nanoseconds(point.time_from_start) * _S for point in points])
    if (np.diff(time) <= 0.0).any() or time[0] < 0.0:
        raise TrajectoryRefusedError(
            "the times of the points do not rise strictly from 0: "
            + ", ".join(f"{item:g}" for item in time[:6]),
        )
    position = np.array([[float(value) for value in point.positions] for point in points])
    velocity = (
        np.array([[float(value) for value in point.velocities] for point in points])
        if all(len(point.velocities) for point in points)
        else None
    )
    if not np.isfinite(position).all() or (
        velocity is not None and not np.isfinite(velocity).all()
    ):
        raise TrajectoryRefusedError("the trajectory holds a number that is not finite")
    stamp_ns = nanoseconds(message.header.stamp)
    if stamp_ns:
        time = time + (stamp_ns - EPOCH_NS - now_ns) * _S
    return _from_now(names, time, position, velocity, twin)


def _check_joints(names: tuple[str, ...], twin: Twin) -> None:
    known = [joint.name for joint in twin.robot.joints]
    if not names:
        raise TrajectoryRefusedError("the trajectory has no joints", TrajectoryCode.INVALID_JOINTS)
    for name in names:
        if name not in known:
            twin.on_unknown_joints(tuple(text for text in names if text))
            raise TrajectoryRefusedError(
                f"robot '{twin.robot.name}' has no joint '{name}'; {one_of(known, name)}",
                TrajectoryCode.INVALID_JOINTS,
            )
    if len(set(names)) != len(names):
        raise TrajectoryRefusedError(
            "the trajectory names a joint twice", TrajectoryCode.INVALID_JOINTS
        )


def _from_now(
    names: tuple[str, ...], time: Array, position: Array, velocity: Array | None, twin: Twin
) -> JointTrajectory:
    here = twin.joint_state().positions
    start = np.array([here[name] for name in names])
    first = int(np.searchsorted(time, 0.0))
    if first == len(time) and time[-1] < 0.0:
        raise TrajectoryRefusedError(
            f"all points lie in the past, the last by {-time[-1]:.3f} s",
            TrajectoryCode.OLD_HEADER_TIMESTAMP,
            is_late=True,
        )
    begins_elsewhere = time[first] == 0.0 and (
        np.abs(position[first] - start).max() > START_TOLERANCE
    )
    if begins_elsewhere and first + 1 < len(time):
        first += 1
    time, position = time[first:], position[first:]
    if velocity is not None:
        velocity = velocity[first:]
    if len(time) == 1:
        # A goal without time for the way is gone to as fast as the joints may.
        least = fastest_s(names, start, position[-1], twin)
        time = np.array([max(float(time[0]), least)])
    if velocity is None:
        velocity = slopes_at(time, position, start)
    return JointTrajectory(names, time, position, velocity)


def fastest_s(names: tuple[str, ...], start: Array, goal: Array, twin: Twin) -> float:
    """Return how long a smooth move from rest to rest takes at the joints' rated figures [s]."""
    joints = [twin.robot.joint(name) for name in names]
    reach = np.abs(goal - start)
    # A cubic is fastest in its middle, with 3/2 of the mean, and turns hardest at its ends.
    by_speed = 1.5 * reach / np.array([joint.velocity_limit for joint in joints])
    by_rise = np.sqrt(6.0 * reach / np.array([joint.acceleration_limit for joint in joints]))
    return max(float(np.maximum(by_speed, by_rise).max()), 0.02)


def slopes_at(time: Array, position: Array, start: Array) -> Array:
    """Return velocities at the points, at rest at the end: monotone between neighbours.

    Fritsch and Butland, "A method for constructing local monotone piecewise cubic interpolants",
    SIAM J. Sci. Stat. Comput. 1984: the harmonic mean of the slopes on both sides, 0 at a turn.
    """
    led = time[0] > 0.0
    times = np.concatenate(([0.0], time)) if led else time
    positions = np.vstack((start, position)) if led else position
    slopes = np.zeros_like(positions)
    if len(times) > 2:
        steps = np.diff(positions, axis=0) / np.diff(times)[:, None]
        before, after = steps[:-1], steps[1:]
        product = before * after
        same = product > 0.0
        total = np.where(same, before + after, 1.0)
        slopes[1:-1] = np.where(same, 2.0 * product / total, 0.0)
    return slopes[1:] if led else slopes
