"""Trajectories as controllers send them, checked as a trajectory controller checks them."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.physics.motion import JointTrajectory

if TYPE_CHECKING:
    from tracerisk.twin.simulation.twin import Twin

Array = NDArray[np.float64]

_S = 1e-9
_START_TOLERANCE = 0.01
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
    """A trajectory that no controller would follow: `code` and the reason."""

    def __init__(self, code: TrajectoryCode, message: str) -> None:
        super().__init__(message)
        self.code = code


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
        raise TrajectoryRefusedError(TrajectoryCode.INVALID_GOAL, "the trajectory has no points")
    for index, point in enumerate(points):
        if len(point.positions) != len(names):
            raise TrajectoryRefusedError(
                TrajectoryCode.INVALID_GOAL,
                f"point {index} has {len(point.positions)} positions for {len(names)} joints",
            )
        if len(point.velocities) not in (0, len(names)):
            raise TrajectoryRefusedError(
                TrajectoryCode.INVALID_GOAL,
                f"point {index} has {len(point.velocities)} velocities for {len(names)} joints",
            )
    time = np.array([nanoseconds(point.time_from_start) * _S for point in points])
    if (np.diff(time) <= 0.0).any() or time[0] < 0.0:
        raise TrajectoryRefusedError(
            TrajectoryCode.INVALID_GOAL,
            "the times of the points do not rise strictly from 0: "
            + ", ".join(f"{each:g}" for each in time[:6]),
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
        raise TrajectoryRefusedError(
            TrajectoryCode.INVALID_GOAL, "the trajectory holds a number that is not finite"
        )
    stamp_ns = nanoseconds(message.header.stamp)
    if stamp_ns:
        time = time + (stamp_ns - EPOCH_NS - now_ns) * _S
    return _from_now(names, time, position, velocity, twin)


def _check_joints(names: tuple[str, ...], twin: Twin) -> None:
    known = [joint.name for joint in twin.robot.joints]
    if not names:
        raise TrajectoryRefusedError(TrajectoryCode.INVALID_JOINTS, "the trajectory has no joints")
    for name in names:
        if name not in known:
            twin.on_unknown_joints(tuple(each for each in names if each))
            raise TrajectoryRefusedError(
                TrajectoryCode.INVALID_JOINTS,
                f"robot '{twin.robot.name}' has no joint '{name}'; {one_of(known, name)}",
            )
    if len(set(names)) != len(names):
        raise TrajectoryRefusedError(
            TrajectoryCode.INVALID_JOINTS, "the trajectory names a joint twice"
        )


def _from_now(
    names: tuple[str, ...], time: Array, position: Array, velocity: Array | None, twin: Twin
) -> JointTrajectory:
    here = twin.joint_state().positions
    start = np.array([here[name] for name in names])
    first = int(np.searchsorted(time, 0.0))
    if first == len(time) and time[-1] < 0.0:
        raise TrajectoryRefusedError(
            TrajectoryCode.OLD_HEADER_TIMESTAMP,
            f"all points lie in the past, the last by {-time[-1]:.3f} s",
        )
    begins_elsewhere = time[first] == 0.0 and (
        np.abs(position[first] - start).max() > _START_TOLERANCE
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
        velocity = _slopes(time, position, start)
    return JointTrajectory(names, time, position, velocity)


def fastest_s(names: tuple[str, ...], start: Array, goal: Array, twin: Twin) -> float:
    """Return how long a smooth move from rest to rest takes at the joints' rated figures [s]."""
    joints = [twin.robot.joint(name) for name in names]
    reach = np.abs(goal - start)
    # A cubic is fastest in its middle, with 3/2 of the mean, and turns hardest at its ends.
    by_speed = 1.5 * reach / np.array([joint.velocity_limit for joint in joints])
    by_rise = np.sqrt(6.0 * reach / np.array([joint.acceleration_limit for joint in joints]))
    return max(float(np.maximum(by_speed, by_rise).max()), 0.02)


def _slopes(time: Array, position: Array, start: Array) -> Array:
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
