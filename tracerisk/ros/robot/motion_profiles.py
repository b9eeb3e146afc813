"""Motion profiles that drives make: of one goal, and of velocities that they keep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics.motion import JointTrajectory

if TYPE_CHECKING:
    from tracerisk.twin.simulation.twin import Twin

_RISE_S = 0.02
_LONGEST_S = 1000.0
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Ramp:
    """How long one joint takes for its way, and for speeding up and slowing down each [s]."""

    duration_s: float
    rise_s: float

    def at(self, start: float, goal: float, time_s: float) -> tuple[float, float]:
        """Return position and velocity at a time on the way from `start` to `goal`."""
        if time_s >= self.duration_s:
            return goal, 0.0
        rise = min(self.rise_s, self.duration_s / 2)
        speed = (goal - start) / (self.duration_s - rise)
        left = self.duration_s - time_s
        if time_s < rise:
            return start + speed * time_s**2 / (2 * rise), speed * time_s / rise
        if left < rise:
            return goal - speed * left**2 / (2 * rise), speed * left / rise
        return start + speed * (time_s - rise / 2), speed


def ramp_of_speed(way: float, speed: float, acceleration: float) -> Ramp:
    """Return the ramp of a way at most at `speed`, with `acceleration`; all positive."""
    rise = speed / acceleration
    if way < speed * rise:
        rise = float(np.sqrt(way / acceleration))
        return Ramp(max(2 * rise, 1e-3), rise)
    return Ramp(way / speed + rise, rise)


def ramped(
    joints: tuple[str, ...], start: Sequence[float], goal: Sequence[float], ramps: Sequence[Ramp]
) -> JointTrajectory:
    """Return the trajectory of joints that leave at once, each on its own ramp.

    Its points are where a ramp changes, so that the cubics between them are the ramps themselves.
    """
    times = sorted(
        {
            round(time, 9)
            for ramp in ramps
            for time in (
                min(ramp.rise_s, ramp.duration_s / 2),
                ramp.duration_s - min(ramp.rise_s, ramp.duration_s / 2),
                ramp.duration_s,
            )
            if time > 1e-6
        }
    )
    points = [
        [ramp.at(a, b, time) for a, b, ramp in zip(start, goal, ramps, strict=True)]
        for time in times
    ]
    return JointTrajectory(
        joints,
        np.array(times),
        np.array([[position for position, _ in point] for point in points]),
        np.array([[velocity for _, velocity in point] for point in points]),
    )


def at_velocities(
    twin: Twin,
    asked: Mapping[str, float],
    for_s: float | None = None,
    start: Mapping[str, float] | None = None,
) -> JointTrajectory | None:
    """Return the way of joints at velocities [rad/s], None where they are at rest.

    It begins at `start`, by default where they are.

    It ends when the first of them is at its limit, or after `for_s` where that is less: they come
    to rest then, as those of a driver that hears no more commands. With `None` it leads on.
    """
    names = tuple(asked)
    joints = [twin.robot.joint(name) for name in names]
    at = {**twin.joint_state().positions, **(start or {})}
    here = np.array([at[name] for name in names])
    speed = np.array(
        [
            float(np.clip(asked[joint.name], -joint.velocity_limit, joint.velocity_limit))
            for joint in joints
        ]
    )
    left = [
        ((joint.upper if v > 0 else joint.lower) - x) / v
        for joint, x, v in zip(joints, here, speed, strict=True)
        if abs(v) > 1e-6
    ]
    if not left:
        return None
    time = min(min(left), _LONGEST_S if for_s is None else for_s)
    if time <= 2 * _RISE_S:
        return None
    times = np.array([_RISE_S, time - _RISE_S, time])
    ways = (_RISE_S / 2, time - 1.5 * _RISE_S, time - _RISE_S)
    return JointTrajectory(
        names,
        times,
        np.vstack([here + speed * way for way in ways]),
        np.vstack((speed, speed, np.zeros(len(names)))),
        leads="on" if for_s is None else "for_a_while",
    )
