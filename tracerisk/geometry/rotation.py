"""Turns of bodies, without the physics engine."""

from __future__ import annotations

import math
from collections.abc import Sequence

Quaternion = tuple[float, float, float, float]
"""A turn as (w, x, y, z)."""


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
