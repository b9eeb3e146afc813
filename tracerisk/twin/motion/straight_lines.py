"""Poses along a straight line in space."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import triple
from tracerisk.twin.physics.motion import PlanningError, Pose

_MAX_WAYPOINTS = 20_000  # of one Cartesian path
_TURN_STEP = 0.1  # the greatest turn between two points of a Cartesian path [rad]


def straight_steps(corners: Sequence[Pose], eef_step: float) -> list[Pose]:
    """Return the poses between corners, at most `eef_step` [m] apart.

    :raises PlanningError: a corner is not finite, or the points are too many.
    """
    steps: list[Pose] = []
    for begin, end in pairwise(corners):
        a, b = np.array(begin.position), np.array(end.position)
        qa, qb = _unit(begin.orientation), _unit(end.orientation)
        if float(qa @ qb) < 0.0:
            qb = -qb
        angle = 2 * math.acos(min(1.0, float(qa @ qb)))
        distance = float(np.linalg.norm(b - a))
        if not math.isfinite(distance):
            raise PlanningError("bad_request", f"waypoint {end.position} is not finite")
        count = max(math.ceil(distance / eef_step), math.ceil(angle / _TURN_STEP), 1)
        if len(steps) + count > _MAX_WAYPOINTS:
            raise PlanningError(
                "bad_request",
                f"eef_step {eef_step:g} m cuts the path into more than {_MAX_WAYPOINTS} points; "
                "give a longer step",
            )
        for i in range(1, count + 1):
            part = i / count
            qx, qy, qz, qw = (float(value) for value in _slerp(qa, qb, angle / 2, part))
            steps.append(Pose(triple(a + part * (b - a)), (qx, qy, qz, qw)))
    return steps


def _unit(orientation: Sequence[float]) -> NDArray[np.float64]:
    quaternion = np.array(orientation, dtype=np.float64)
    norm = float(np.linalg.norm(quaternion))
    if not math.isfinite(norm) or norm < 1e-6:
        raise PlanningError(
            "bad_request", f"orientation {tuple(orientation)} is not a quaternion (x, y, z, w)"
        )
    return quaternion / norm


def _slerp(
    a: NDArray[np.float64], b: NDArray[np.float64], half_angle: float, part: float
) -> NDArray[np.float64]:
    mixed: NDArray[np.float64]
    if half_angle < 1e-6:
        mixed = a + part * (b - a)
    else:
        mixed = math.sin((1 - part) * half_angle) * a + math.sin(part * half_angle) * b
    return _unit(mixed.tolist())
