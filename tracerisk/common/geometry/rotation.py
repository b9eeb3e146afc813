"""Turns of bodies, without the physics engine."""

from __future__ import annotations

import math
from collections.abc import Sequence

Quaternion = tuple[float, float, float, float]
"""A turn as (w, x, y, z)."""
Vector = tuple[float, float, float]


def quaternion_of(rpy: Sequence[float]) -> Quaternion:
    """Return roll, pitch, yaw about fixed axes [rad] as a quaternion (w, x, y, z)."""
    (sr, sp, sy), (cr, cp, cy) = (
        [math.sin(angle / 2) for angle in rpy],
        [math.cos(angle / 2) for angle in rpy],
    )
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def product(one: Quaternion, other: Quaternion) -> Quaternion:
    """Return the quaternion that turns by `other` and then by `one`."""
    a, b, c, d = one
    e, f, g, h = other
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def rotated(turn: Quaternion, vector: Sequence[float]) -> Vector:
    """Return a vector turned by a quaternion of unit length."""
    w, x, y, z = turn
    a, b, c = vector
    # v + 2 w (q x v) + 2 q x (q x v)
    i, j, k = y * c - z * b, z * a - x * c, x * b - y * a
    return (
        a + 2 * (w * i + y * k - z * j),
        b + 2 * (w * j + z * i - x * k),
        c + 2 * (w * k + x * j - y * i),
    )
