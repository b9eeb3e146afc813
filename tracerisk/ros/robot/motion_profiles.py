"""Motion profiles that drives make of one goal: speed that rises, stays and falls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics.motion import JointTrajectory

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
