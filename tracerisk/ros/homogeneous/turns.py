"""Quaternions (x, y, z, w) and the 24 kinds of Euler angles.

A kind is named `sxyz` or `rzyx`: about static or rotating axes, in this order; or it is the tuple
(first axis, parity, repetition, frame) of Shoemake, Graphics Gems IV, 1994, from which the
conversion of matrices to angles is taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from tracerisk.ros.homogeneous.vectors import EPS, Array, random_vector, unit_vector

Axes = str | tuple[int, int, int, int]


def _kinds() -> dict[str, tuple[int, int, int, int]]:
    orders = ["".join(order) for order in permutations("xyz")]
    orders += [order[:2] + order[0] for order in orders]
    kinds = {}
    for frame, letter in enumerate("sr"):
        for order in orders:
            # Turns about rotating axes are those about static ones in the opposite order.
            named = order[::-1] if frame else order
            first, second = "xyz".index(named[0]), "xyz".index(named[1])
            parity = int(second != (first + 1) % 3)
            kinds[letter + order] = (first, parity, int(order[0] == order[2]), frame)
    return kinds


AXES = _kinds()
"""Each kind of Euler angles as its tuple."""


def _kind(axes: Axes) -> tuple[int, int, int, int]:
    if isinstance(axes, str):
        return AXES[axes.lower()]
    if tuple(axes) not in AXES.values():
        raise KeyError(axes)
    return axes


def _order(first: int, parity: int) -> tuple[int, int, int]:
    return first, (first + 1 + parity) % 3, (first + 2 - parity) % 3


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> Array:
    """Return the quaternion of three Euler angles [rad]: (4,).

    Raises:
        KeyError: there is no such kind of angles.
    """
    first, parity, repetition, frame = _kind(axes)
    i, j, k = _order(first, parity)
    angles = (ak, aj, ai) if frame else (ai, aj, ak)
    turn = np.array([0.0, 0.0, 0.0, 1.0])
    for angle, axis in zip(angles, (i, j, i if repetition else k), strict=True):
        step = np.zeros(4)
        step[axis], step[3] = math.sin(angle / 2.0), math.cos(angle / 2.0)
        turn = quaternion_multiply(step, turn)
    return turn


def euler_matrix(ai: float, aj: float, ak: float, axes: Axes = "sxyz") -> Array:
    """Return the rotation of three Euler angles [rad]: (4, 4).

    Raises:
        KeyError: there is no such kind of angles.
    """
    return quaternion_matrix(quaternion_from_euler(ai, aj, ak, axes))


def euler_from_matrix(matrix: ArrayLike, axes: Axes = "sxyz") -> tuple[float, float, float]:
    """Return the Euler angles of a rotation, (4, 4) or (3, 3) [rad].

    Where only the sum or difference of two angles is defined, the other is 0.

    Raises:
        KeyError: there is no such kind of angles.
    """
    first, parity, repetition, frame = _kind(axes)
    i, j, k = _order(first, parity)
    m = np.asarray(matrix, dtype=np.float64)[:3, :3]
    if repetition:
        length = math.hypot(m[i, j], m[i, k])
        angles = [math.atan2(m[i, j], m[i, k]), math.atan2(length, m[i, i])]
        last = math.atan2(m[j, i], -m[k, i])
    else:
        length = math.hypot(m[i, i], m[j, i])
        angles = [math.atan2(m[k, j], m[k, k]), math.atan2(-m[k, i], length)]
        last = math.atan2(m[j, i], m[i, i])
    if length <= EPS:
        angles[0], last = math.atan2(-m[j, k], m[j, j]), 0.0
    sign = -1.0 if parity else 1.0
    ax, ay, az = (sign * angle for angle in (*angles, last))
    return (az, ay, ax) if frame else (ax, ay, az)


def euler_from_quaternion(
    quaternion: Sequence[float], axes: Axes = "sxyz"
) -> tuple[float, float, float]:
    """Return the Euler angles of a quaternion [rad]; see `euler_from_matrix`."""
    return euler_from_matrix(quaternion_matrix(quaternion), axes)


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Array:
    """Return the turn by an angle [rad] about an axis: (4,)."""
    direction = np.asarray(axis, dtype=np.float64)[:3]
    length = float(np.linalg.norm(direction))
    turn = np.zeros(4)
    # Without a direction the real library leaves the axis at 0 as well.
    turn[:3] = direction if length <= EPS else direction * (math.sin(angle / 2.0) / length)
    turn[3] = math.cos(angle / 2.0)
    return turn


def quaternion_matrix(quaternion: ArrayLike) -> Array:
    """Return the rotation of a quaternion of any length: (4, 4); that of length 0 is none."""
    q = np.asarray(quaternion, dtype=np.float64)[:4]
    matrix = np.identity(4)
    square = float(q @ q)
    if square < EPS:
        return matrix
    x, y, z, w = q
    s = 2.0 / square
    matrix[:3, :3] = (
        (1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)),
    )
    return matrix


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Return the quaternion of a rotation (4, 4): (4,), its largest number positive.

    A positive trace counts as the largest (Shepperd, 1978).
    """
    given = np.asarray(matrix, dtype=np.float64)
    m = given[:3, :3] / (given[3, 3] if given.shape == (4, 4) else 1.0)
    turn = np.empty(4)
    trace = float(np.trace(m))
    if trace > 0.0:
        square = 1.0 + trace
        turn[:] = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], square
    else:
        i = int(np.argmax(np.diag(m)))
        j, k = (i + 1) % 3, (i + 2) % 3
        square = 1.0 + m[i, i] - m[j, j] - m[k, k]
        turn[i], turn[3] = square, m[k, j] - m[j, k]
        turn[j], turn[k] = m[i, j] + m[j, i], m[k, i] + m[i, k]
    return np.asarray(turn * (0.5 / math.sqrt(square)))


def quaternion_multiply(quaternion1: ArrayLike, quaternion0: ArrayLike) -> Array:
    """Return the turn `quaternion0` followed by `quaternion1`: (4,)."""
    ax, ay, az, aw = np.asarray(quaternion1, dtype=np.float64)
    bx, by, bz, bw = np.asarray(quaternion0, dtype=np.float64)
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Return the quaternion with its axis turned around: (4,)."""
    x, y, z, w = np.asarray(quaternion, dtype=np.float64)
    return np.array([-x, -y, -z, w])


def quaternion_inverse(quaternion: ArrayLike) -> Array:
    """Return the quaternion that undoes another: (4,)."""
    q = np.asarray(quaternion, dtype=np.float64)
    return np.asarray(quaternion_conjugate(q) / (q @ q))


def quaternion_slerp(
    quat0: ArrayLike, quat1: ArrayLike, fraction: float, spin: int = 0, shortestpath: bool = True
) -> Array:
    """Return the turn at a fraction of the way between two (Shoemake, 1985): (4,).

    `spin` adds half turns, `shortestpath` takes the shorter way round.
    """
    begin: Array = np.asarray(unit_vector(quat0)[:4])
    end: Array = np.asarray(unit_vector(quat1)[:4])
    if fraction == 0.0:
        return begin
    if fraction == 1.0:
        return end
    cosine = float(begin @ end)
    if abs(abs(cosine) - 1.0) < EPS:
        return begin
    if shortestpath and cosine < 0.0:
        cosine, end = -cosine, -end
    angle = math.acos(cosine) + spin * math.pi
    if abs(angle) < EPS:
        return begin
    parts = math.sin((1.0 - fraction) * angle) * begin + math.sin(fraction * angle) * end
    return np.asarray(parts / math.sin(angle))


def random_quaternion(rand: ArrayLike | None = None) -> Array:
    """Return a turn, all equally likely, of three numbers in [0, 1) (Shoemake, 1992): (4,)."""
    numbers = random_vector(3) if rand is None else np.asarray(rand, dtype=np.float64)
    if len(numbers) != 3:
        raise AssertionError("rand must hold three numbers")
    first, second = 2.0 * math.pi * numbers[1:]
    r1, r2 = math.sqrt(1.0 - numbers[0]), math.sqrt(numbers[0])
    return np.array(
        [
            math.sin(first) * r1,
            math.cos(first) * r1,
            math.sin(second) * r2,
            math.cos(second) * r2,
        ]
    )


def random_rotation_matrix(rand: ArrayLike | None = None) -> Array:
    """Return a rotation, all equally likely: (4, 4)."""
    return quaternion_matrix(random_quaternion(rand))
