"""Positions between the points of a trajectory, as a spline through them gives them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def resample(
    time: Array,
    position: Array,
    velocity: Array,
    step_s: float,
    degree: NDArray[np.int8] | None = None,
    acceleration: Array | None = None,
) -> tuple[Array, Array]:
    """Return position and velocity at every `step_s` after the first point, the last included.

    time: (n_points,), position, velocity and acceleration: (n_points, n_joints); degree:
    (n_points,) as of `JointTrajectory`. Returns two arrays (n_steps, n_joints); past the last
    point the path rests there.
    """
    n_steps = max(1, math.ceil(round(float(time[-1]) / step_s, 6)))
    at: Array = np.arange(1.0, n_steps + 1) * step_s
    return states_at(at, time, position, velocity, degree, acceleration)


def states_at(
    at: Array,
    time: Array,
    position: Array,
    velocity: Array,
    degree: NDArray[np.int8] | None = None,
    acceleration: Array | None = None,
) -> tuple[Array, Array]:
    """Return position and velocity of a path at some times, each (n_times, n_joints).

    Between points it is the polynomial that `degree` says, by default the cubic that has their
    positions and velocities. Past the last point it rests there.
    """
    if len(time) == 1:
        rest = np.repeat(position[-1:], len(at), axis=0)
        return rest, np.zeros_like(rest)
    index = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    width = (time[index + 1] - time[index])[:, None]
    u = np.clip((at - time[index])[:, None] / width, 0.0, 1.0)
    p0, p1 = position.take(index, axis=0), position.take(index + 1, axis=0)
    v0 = velocity.take(index, axis=0) * width
    v1 = velocity.take(index + 1, axis=0) * width
    u2, u3 = u * u, u * u * u
    sampled = (
        (2 * u3 - 3 * u2 + 1) * p0 + (u3 - 2 * u2 + u) * v0
        + (3 * u2 - 2 * u3) * p1 + (u3 - u2) * v1
    )  # fmt: skip
    slope = (
        (6 * u2 - 6 * u) * p0 + (3 * u2 - 4 * u + 1) * v0
        + (6 * u - 6 * u2) * p1 + (3 * u2 - 2 * u) * v1
    ) / width  # fmt: skip
    if degree is not None:
        of_span = degree[index + 1]
        waits, straight, smooth = of_span == 0, of_span == 1, of_span == 5
        # Most paths are cubics throughout: what no span is, is not computed for all times.
        if waits.any():
            sampled[waits], slope[waits] = p0[waits], 0.0
        if straight.any():
            slope[straight] = ((p1 - p0) / width)[straight]
            sampled[straight] = (p0 + (p1 - p0) * u)[straight]
        if smooth.any():
            bend = np.zeros_like(position) if acceleration is None else acceleration
            a0, a1 = bend[index] * width**2, bend[index + 1] * width**2
            more, rise = _quintic_beside_cubic(u, p0, p1, v0, v1, a0, a1)
            sampled[smooth] += more[smooth]
            slope[smooth] += (rise / width)[smooth]
    past = at >= time[-1]
    sampled[past], slope[past] = position[-1], 0.0
    return sampled, slope


def _quintic_beside_cubic(
    u: Array, p0: Array, p1: Array, v0: Array, v1: Array, a0: Array, a1: Array
) -> tuple[Array, Array]:
    """Return what the quintic of a span differs by from its cubic, and the derivative by `u`.

    u: from 0 to 1; velocities and accelerations are per span. The difference is 0 with its slope
    at both ends, u^2 (1 - u)^2 (c + d u): c and d make up for the accelerations of the cubic.
    """
    missing0 = a0 - (6 * (p1 - p0) - 4 * v0 - 2 * v1)
    missing1 = a1 - (-6 * (p1 - p0) + 2 * v0 + 4 * v1)
    c = missing0 / 2
    d = missing1 / 2 - c
    bell = u * u * (1 - u) ** 2
    return bell * (c + d * u), 2 * u * (1 - u) * (1 - 2 * u) * (c + d * u) + bell * d
