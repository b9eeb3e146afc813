"""Put a path of joint positions in time, within limits of velocity and acceleration.

A straight line between two positions gets smooth ramps of speed.
Any other path is timed as fast as the limits allow, by the phase-plane method (Bobrow, Dubowsky
and Gibson, "Time-optimal control of robotic manipulators along specified paths", IJRR 1985) with
limits on joint acceleration in place of torque: along the path parameter s the squared speed
x = (ds/dt)^2 has to satisfy |q'| sqrt(x) <= v and |q' u + q'' x| <= a with u = (dx/ds)/2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_POINT_S = 0.02  # spacing of the points of a timed straight line, at most [s]
_FEWEST_POINTS = 41  # between which a cubic keeps the limits to a few percent
_MOST_POINTS = 2001  # of a line however slow, which a cubic between them follows as well
_TINY = 1e-9


def straight_line(
    start: Array, goal: Array, velocity: Array, acceleration: Array
) -> tuple[Array, Array, Array]:
    """Return time, position and velocity of a synchronised move from rest to rest.

    start, goal, velocity, acceleration: (n_joints,); the limits are absolute and already scaled.
    Returns time (n_points,) [s] and position, velocity (n_points, n_joints).
    The speed rises and falls as 3u^2 - 2u^3, whose steepest slope is 3/2 of its mean, so a ramp
    to speed v lasts 1.5 v / a.
    """
    delta = goal - start
    reach = np.abs(delta)
    if float(reach.max(initial=0.0)) < _TINY:
        return np.zeros(1), goal[None, :].copy(), np.zeros((1, len(goal)))
    moving = reach >= _TINY
    top = float(np.min(velocity[moving] / reach[moving]))
    rise = float(np.min(acceleration[moving] / reach[moving]))
    # Both ramps together cover v * ramp of the path; a short path ends before full speed.
    top = min(top, math.sqrt(rise / 1.5))
    ramp = 1.5 * top / rise
    cruise = (1.0 - top * ramp) / top
    duration = 2 * ramp + cruise
    n_points = min(max(_FEWEST_POINTS, math.ceil(duration / _POINT_S) + 1), _MOST_POINTS)
    time = np.linspace(0.0, duration, n_points)
    fraction, speed = _ramped(time, top, ramp, duration)
    fraction[-1], speed[-1] = 1.0, 0.0
    position = start + fraction[:, None] * delta
    position[-1] = goal
    return time, position, speed[:, None] * delta


def _ramped(time: Array, top: float, ramp: float, duration: float) -> tuple[Array, Array]:
    rising = np.clip(time / ramp, 0.0, 1.0)
    falling = np.clip((duration - time) / ramp, 0.0, 1.0)
    speed = top * np.minimum(_smooth(rising), _smooth(falling))
    # The integral of 3u^2 - 2u^3 is u^3 - u^4/2.
    begun = top * ramp * (rising**3 - rising**4 / 2)
    left = top * ramp * (falling**3 - falling**4 / 2)
    cruising = top * np.clip(time - ramp, 0.0, duration - 2 * ramp)
    fraction = np.where(
        time <= duration - ramp, begun + np.where(time > ramp, cruising, 0.0), 1.0 - left
    )
    return fraction, speed


def _smooth(u: Array) -> Array:
    return u * u * (3 - 2 * u)


def along_path(path: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return time, position and velocity along a path, at rest at both ends.

    path: (n_points, n_joints); points that repeat the one before are dropped.
    velocity, acceleration: (n_joints,), absolute and already scaled.
    Returns time (m,), position (m, n_joints), velocity (m, n_joints), m <= n_points.
    """
    points = _distinct(path)
    if len(points) == 1:
        return np.zeros(1), points, np.zeros_like(points)
    if len(points) == 2:
        return straight_line(points[0], points[1], velocity, acceleration)
    step = np.abs(np.diff(points, axis=0) / velocity).max(axis=1)
    s = np.concatenate(([0.0], np.cumsum(step)))
    first = np.gradient(points, s, axis=0)
    second = np.gradient(first, s, axis=0)
    ceiling = _speed_ceiling(first, second, velocity, acceleration)
    ceiling[0] = ceiling[-1] = 0.0
    squared = _forward(s, ceiling, first, second, acceleration)
    squared = _forward((s[-1] - s)[::-1], squared[::-1], first[::-1], second[::-1], acceleration)[
        ::-1
    ]
    speed = np.sqrt(squared)
    mean = np.maximum((speed[1:] + speed[:-1]) / 2, _TINY)
    time = np.concatenate(([0.0], np.cumsum(np.diff(s) / mean)))
    return time, points, first * speed[:, None]


def _distinct(path: Array) -> Array:
    moved = np.abs(np.diff(path, axis=0)).max(axis=1) > _TINY
    return path[np.concatenate(([True], moved))]


def _speed_ceiling(first: Array, second: Array, velocity: Array, acceleration: Array) -> Array:
    with np.errstate(divide="ignore"):
        by_velocity = (velocity / np.abs(first)).min(axis=1) ** 2
        by_curvature = (acceleration / np.abs(second)).min(axis=1)
    ceiling: Array = np.minimum(by_velocity, by_curvature)
    return ceiling


def _forward(s: Array, ceiling: Array, first: Array, second: Array, acceleration: Array) -> Array:
    """Return the highest squared speed under `ceiling` that the acceleration can build up."""
    squared = ceiling.copy()
    for i in range(len(s) - 1):
        spare = acceleration - np.abs(second[i]) * squared[i]
        steep = np.abs(first[i]) > _TINY
        gain = float((np.maximum(spare, 0.0)[steep] / np.abs(first[i])[steep]).min(initial=np.inf))
        squared[i + 1] = min(squared[i + 1], squared[i] + 2 * gain * (s[i + 1] - s[i]))
    return squared


def resample(time: Array, position: Array, velocity: Array, step_s: float) -> tuple[Array, Array]:
    """Return position and velocity at every `step_s` after the first point, the last included.

    time: (n_points,), position and velocity: (n_points, n_joints).
    Returns two arrays (n_steps, n_joints); between points the path is the cubic that has their
    positions and velocities, and past the last point it rests there.
    """
    n_steps = max(1, math.ceil(round(float(time[-1]) / step_s, 6)))
    at = np.arange(1, n_steps + 1) * step_s
    index = np.clip(np.searchsorted(time, at, side="right") - 1, 0, max(len(time) - 2, 0))
    if len(time) == 1:
        rest = np.repeat(position[-1:], n_steps, axis=0)
        return rest, np.zeros_like(rest)
    width = (time[index + 1] - time[index])[:, None]
    u = np.clip((at - time[index])[:, None] / width, 0.0, 1.0)
    p0, p1 = position[index], position[index + 1]
    v0, v1 = velocity[index] * width, velocity[index + 1] * width
    u2, u3 = u * u, u * u * u
    sampled = (
        (2 * u3 - 3 * u2 + 1) * p0 + (u3 - 2 * u2 + u) * v0
        + (3 * u2 - 2 * u3) * p1 + (u3 - u2) * v1
    )  # fmt: skip
    slope = (
        (6 * u2 - 6 * u) * p0 + (3 * u2 - 4 * u + 1) * v0
        + (6 * u - 6 * u2) * p1 + (3 * u2 - 2 * u) * v1
    ) / width  # fmt: skip
    past = at >= time[-1]
    sampled[past], slope[past] = position[-1], 0.0
    return sampled, slope
