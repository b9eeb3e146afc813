"""Compare an object's place with the goals of its scene."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.rotation import quaternion_of
from tracerisk.trace import ObjectOffset
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene import Goal, GraspableObject

_UPRIGHT_TILT = math.radians(5.0)
_UPRIGHT_HEIGHT = 0.005  # an object this far above or below its goal does not stand in it [m]


def offsets(
    placed: Sequence[tuple[GraspableObject, Pose]], goals: Sequence[Goal]
) -> tuple[ObjectOffset, ...]:
    """Return the offset of each object from the nearest goal; of one astray from a free one.

    A goal at which another object stands is not free; where none is free, all count.
    """
    nearest = [offset(thing, pose, goals) for thing, pose in placed]
    taken = {result.goal for result in nearest if result.stands_at_goal}
    free = [goal for goal in goals if goal.name not in taken] or goals
    return tuple(
        result if result.stands_at_goal else offset(thing, pose, free)
        for result, (thing, pose) in zip(nearest, placed, strict=True)
    )


def offset(thing: GraspableObject, pose: Pose, goals: Sequence[Goal]) -> ObjectOffset:
    """Return the horizontal offset of an object from the nearest goal, and its tilt.

    The tilt is the angle by which its z axis has left its first direction [rad].
    It is upright when it has tilted less than 5 degrees and, where there is a goal, stands
    within 5 mm of the goal's height.
    """
    x, y, z = pose.position
    qx, qy, qz, qw = pose.orientation
    cosine = float(_z_axis(qw, qx, qy, qz) @ _z_axis(*quaternion_of(thing.rpy)))
    tilt = math.acos(min(1.0, max(-1.0, cosine)))
    if not goals:
        return ObjectOffset(thing.name, None, 0.0, tilt, tilt < _UPRIGHT_TILT)
    goal = min(goals, key=lambda goal: math.hypot(x - goal.xyz[0], y - goal.xyz[1]))
    away = math.hypot(x - goal.xyz[0], y - goal.xyz[1])
    upright = tilt < _UPRIGHT_TILT and abs(z - goal.xyz[2]) < _UPRIGHT_HEIGHT
    return ObjectOffset(thing.name, goal.name, away, tilt, upright)


def _z_axis(w: float, x: float, y: float, z: float) -> NDArray[np.float64]:
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
