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
    """The speed profile of one joint: an even rise, a steady speed, an even fall."""

    duration_s: float
    """The time for the whole way [s]."""
    rise_s: float
    """The time for speeding up, and again for slowing down [s]."""

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
    rise_s: float = _RISE_S,
) -> JointTrajectory | None:
    """Return the way of joints to velocities [rad/s] and on with these, None for joints at rest.

    They speed up evenly from what their set-points do now, within `rise_s` or as their limits of
    acceleration allow. They come to rest when the first of them is at its limit, and begin to after
    `for_s`, as those of a driver that hears no more commands. With `None` it leads on.
    """
    names = tuple(asked)
    joints = [twin.robot.joint(name) for name in names]
    here, now = twin.reference(names)
    rated = np.array([joint.velocity_limit for joint in joints])
    rise_limit = np.array([twin.robot.followed_rise(name) for name in names])
    speed = np.clip(np.array(list(asked.values())), -rated, rated)
    moves = np.abs(speed) > 1e-6
    if not moves.any():
        return None
    limits = np.array([j.upper if v > 0 else j.lower for j, v in zip(joints, speed, strict=True)])
    least = min(rise_s, for_s / 2) if for_s else rise_s
    rise = max(float((np.abs(speed - now) / rise_limit).max()), least)
    fall = max(float((np.abs(speed) / rise_limit).max()), min(_RISE_S, least))
    ways = (now + speed) / 2 * rise, speed / 2 * fall
    steady = float(np.min(((limits - here - sum(ways)) / np.where(moves, speed, 1.0))[moves]))
    if steady <= 0.0:
        if (np.abs(now) > np.abs(speed) / 2)[moves].any():
            # What moves them comes to rest there already.
            return None
        # Too near for its speed: there and to rest within the distance that is left.
        left = float(np.min(((limits - here) / np.where(moves, speed, 1.0))[moves]))
        if left <= _RISE_S:
            return None
        rise = fall = left
        ways = (now + speed) / 2 * rise, speed / 2 * fall
        steady = 1e-3
    steady = min(steady, _LONGEST_S)
    if for_s is not None:
        steady = min(steady, max(for_s - rise, 1e-3))
    at = here + ways[0]
    rest = at + speed * steady
    return JointTrajectory(
        names,
        np.array([rise, rise + steady, rise + steady + fall]),
        np.vstack((at, rest, rest + ways[1])),
        np.vstack((speed, speed, np.zeros(len(names)))),
        leads="on" if for_s is None else "for_a_while",
    )
