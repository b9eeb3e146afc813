"""Trajectories of messages as the twin follows them: start, past points, and the way between."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.trajectories.checks import PAST_POINTS, Asked
from tracerisk.ros.robot.trajectory_messages import (
    START_TOLERANCE,
    TrajectoryCode,
    TrajectoryRefusedError,
    fastest_s,
    slopes_at,
)
from tracerisk.twin.physics.motion import STEP_S, JointTrajectory
from tracerisk.twin.simulation.twin import Twin

START = "trajectory-start"
WRAPAROUND = "trajectory-wraparound"
UPDATE_S = 0.01
"""From one set-point of a controller to the next [s]: the default `update_rate` of
ros-controls/ros2_control controller_manager, 100 Hz."""

Array = NDArray[np.float64]


def timed(asked: Asked, twin: Twin) -> JointTrajectory:
    """Return what a trajectory that is not refused asks of the twin from now on.

    Raises:
        TrajectoryRefusedError: no point of it lies in the future, where past ones are dropped.
    """
    columns = {name: at for at, name in enumerate(asked.names)}  # of a name twice the later counts
    names, order = tuple(columns), list(columns.values())
    here = twin.joint_state().positions
    start = np.array([here[name] for name in names])
    first = _first_point(asked)
    points = asked.points[first:]
    time = np.array(asked.times_s()[first:])
    position, velocity, acceleration = _filled(points, order, start, time)
    position = position + _turns(asked, names, start, position[0], twin)
    degrees = _degrees(points, asked.settings.interpolates)
    begins_elsewhere = time[0] <= 0.0 and np.abs(position[0] - start).max() > START_TOLERANCE
    if begins_elsewhere and len(time) > 1:
        time, position, velocity = time[1:], position[1:], velocity[1:]
        acceleration, degrees = acceleration[1:], degrees[1:]
    degree: NDArray[np.int8] | None = degrees
    if len(time) == 1 and time[0] <= 0.0:
        # A goal without time for the way is gone to as fast as the joints may.
        time, degree = np.array([fastest_s(names, start, position[-1], twin)]), None
        velocity = np.zeros_like(position)
    elif not asked.settings.interpolates:
        # Each point is the set-point until the next one is due.
        position = np.vstack((position[1:], position[-1:])) if len(time) > 1 else position
        velocity = np.zeros_like(position)
    else:
        lacks = [at for at, point in enumerate(points[-len(time) :]) if not len(point.velocities)]
        velocity[lacks] = slopes_at(time, position, start)[lacks]
    made = JointTrajectory(names, time, position, velocity, "to_goal", degree, acceleration)
    return _started(asked, made, twin)


def _first_point(asked: Asked) -> int:
    """Return the first point that is followed.

    ROS 1 drops those that are not after the next update of the controller, a start point at time
    0 included; a trajectory of ROS 2 is entered where it is.
    """
    times = asked.times_s()
    if asked.rules.value(PAST_POINTS) == "dropped":
        # Without a stamp the trajectory itself begins at that update.
        begin_s = STEP_S if nanoseconds(asked.message.header.stamp) else 0.0
        first = next((at for at, time in enumerate(times) if time > begin_s), len(times))
        if first == len(times):
            one = len(times) == 1
            what = "its point is dropped: it" if one else "all its points are dropped: the last"
            is_past = times[-1] < -STEP_S
            when = f"comes {-times[-1]:.3f} s before" if is_past else "does not come after"
            raise TrajectoryRefusedError(
                f"{what} {when} the present; give time_from_start a time after the start",
                TrajectoryCode.INVALID_GOAL,
                is_late=True,
            )
        return first
    first = next((at for at, time in enumerate(times) if time >= 0.0), len(times))
    return min(first, len(times) - 1)


def left_out(asked: Asked, twin: Twin, what: str) -> str:
    """Return words on points that move nothing though the joints are elsewhere; "" for none.

    A controller of ROS 1 drops past points; one of ROS 2 would step to a start point at time 0,
    which the twin passes over. `what` carries the trajectory, for example "a goal of action /a".
    """
    count, first = len(asked.points), _first_point(asked)
    if asked.rules.value(PAST_POINTS) == "dropped":
        here = twin.joint_state().positions if first else {}
        n_dropped = sum(bool(_elsewhere(asked, at, here, twin)) for at in range(first))
        if not n_dropped:
            return ""
        return (
            f"{n_dropped} of {count} points of {what} moved nothing: they lie in the past, and "
            "are dropped"
        )
    if first == count - 1 or asked.times_s()[first] > 0.0:
        return ""
    gaps = _elsewhere(asked, first, twin.joint_state().positions, twin)
    most = {name: twin.robot.joint(name).velocity_limit * UPDATE_S for name in gaps}
    steps = {name: gap for name, gap in gaps.items() if gap > most[name]}
    if not steps:
        return ""
    name = max(steps, key=lambda name: steps[name])
    return (
        f"the first of {count} points of {what} moved nothing: at its time, 0 s, {name!r} is "
        f"{steps[name]:.3f} {twin.robot.joint(name).unit} away, and a real controller would step "
        "there at once; begin where the arm is, or give the point a time to get there"
    )


def _elsewhere(asked: Asked, at: int, here: Mapping[str, float], twin: Twin) -> dict[str, float]:
    """Return how far the joints are from a point, those that are further than a start may be."""
    points = zip(asked.names, asked.points[at].positions, strict=False)
    gaps = {name: position - here[name] for name, position in points}
    for name in gaps:
        if wraps(asked, name, twin):
            gaps[name] = math.remainder(gaps[name], 2 * math.pi)
    return {name: abs(gap) for name, gap in gaps.items() if abs(gap) > START_TOLERANCE}


def _filled(points: Any, order: list[int], start: Array, time: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations of points, with 0 where none are given.

    A point without positions is where its velocities, or accelerations, lead from the one before.
    """
    shape = (len(points), len(order))
    position, velocity, acceleration = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    before = (start, np.zeros(len(order)), np.zeros(len(order)), 0.0)
    for at, point in enumerate(points):
        span = time[at] - before[3]
        if len(point.accelerations):
            acceleration[at] = np.array(point.accelerations, dtype=float)[order]
        if len(point.velocities):
            velocity[at] = np.array(point.velocities, dtype=float)[order]
        elif not len(point.positions):
            velocity[at] = before[1] + (before[2] + acceleration[at]) / 2 * span
        if len(point.positions):
            position[at] = np.array(point.positions, dtype=float)[order]
        else:
            position[at] = before[0] + (before[1] + velocity[at]) / 2 * span
        before = (position[at], velocity[at], acceleration[at], time[at])
    return position, velocity, acceleration


def _degrees(points: Any, interpolates: bool) -> NDArray[np.int8]:
    """Return the degree of the way to each point: by what both of its ends give."""
    if not interpolates:
        return np.zeros(len(points), np.int8)
    own = [_degree(point) for point in points]
    # The state where it begins has a velocity, and an acceleration where the first point has one.
    return np.array([min(pair) for pair in zip([own[0], *own], own, strict=False)], np.int8)


def _degree(point: Any) -> int:
    if not len(point.velocities):
        return 1 if len(point.positions) else 3
    return 5 if len(point.accelerations) else 3


def _turns(asked: Asked, names: tuple[str, ...], start: Array, first: Array, twin: Twin) -> Array:
    """Return by how much the positions of joints that turn without end are shifted: whole turns."""
    shift = np.zeros(len(names))
    for at, name in enumerate(names):
        if wraps(asked, name, twin):
            shift[at] = 2 * math.pi * round((start[at] - first[at]) / (2 * math.pi))
    return shift


def wraps(asked: Asked, name: str, twin: Twin) -> bool:
    """Return whether a controller takes the shortest way of a joint, whatever the turns."""
    if asked.rules.value(WRAPAROUND) == "continuous joints":
        return twin.robot.joint(name).type == "continuous"
    return name in asked.settings.wraps


def _started(asked: Asked, made: JointTrajectory, twin: Twin) -> JointTrajectory:
    """Return a trajectory with what is done before its start time, where that is to come."""
    stamp_ns = nanoseconds(asked.message.header.stamp)
    span_s = asked.times_s()[0] - nanoseconds(asked.points[0].time_from_start) * 1e-9
    if not stamp_ns or span_s <= STEP_S or asked.rules.value(START) != "waits":
        return made
    steps = round(span_s / STEP_S)
    position, velocity = twin.references_ahead(made.joints, steps)
    is_later = made.time > span_s + STEP_S / 2
    kept = np.unique(np.linspace(0, steps - 1, min(steps, 2 + steps // 5)).astype(int))
    at = (kept + 1) * STEP_S

    def joined(before: Array, after: Array) -> Array:
        return np.concatenate((before, after[is_later]))

    degree = np.full(len(made.time), 3, np.int8) if made.degree is None else made.degree
    bend = np.zeros_like(made.position) if made.acceleration is None else made.acceleration
    return JointTrajectory(
        made.joints,
        joined(at, made.time),
        joined(position[kept], made.position),
        joined(velocity[kept], made.velocity),
        "to_goal",
        np.concatenate((np.full(len(kept), 3, np.int8), degree[is_later])),
        joined(np.zeros((len(kept), len(made.joints))), bend),
    )
