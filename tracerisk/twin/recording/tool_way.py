"""The arm of a robot whose joints a run commanded, and where its tool was along the run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import rotation, skew
from tracerisk.common.outcome.arm import Arm, ArmFrame, Position

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot
    from tracerisk.twin.robots.robot_parts import Attachment

_STEP = 1e-4  # the frames of an arm are kept in whole steps of 0.1 mm and 0.1 mrad

Array = NDArray[np.float64]


def arm_of(robot: Robot, commanded: Sequence[str]) -> Arm:
    """Return the arm that moves the commanded joints, from the robot's base to its tool.

    The tool is the tip of a planning group, else the link that is carried furthest out.
    """
    joints = set(commanded)

    def moved_by(link: str) -> int:
        return sum(1 for hung in robot.above(link) if hung.name in joints)

    most = max(map(moved_by, robot.link_names))
    tips = (group.tip_link for group in robot.groups.values() if joints & set(group.joints))
    named = (tip for tip in tips if tip is not None and moved_by(tip) == most)
    tool = next(named, next(link for link in robot.link_names if moved_by(link) == most))
    arm = arm_to(robot, tool)
    return Arm((*arm.joints, *(name for name in commanded if name not in arm.joints)), arm.frames)


def arm_to(robot: Robot, link: str) -> Arm:
    """Return what moves a link: the joints between it and the robot's base."""
    chain = list(robot.above(link))[::-1]
    known = {joint.name for joint in robot.joints}
    moving = (hung.name for hung in chain if hung.type != "fixed" and hung.name in known)
    return Arm(tuple(moving), tuple(map(_frame, chain)))


def _frame(hung: Attachment) -> ArmFrame:
    is_fixed = hung.type == "fixed"
    axis = np.asarray(hung.axis, dtype=np.float64)
    unit = (0.0, 0.0, 1.0) if is_fixed else _rounded(axis / np.linalg.norm(axis))
    return ArmFrame(
        xyz_m=_rounded(hung.xyz),
        rpy=_rounded(hung.rpy),
        joint="" if is_fixed else hung.name,
        axis=unit,
        slides=hung.type == "prismatic",
    )


def _rounded(values: Sequence[float] | Array) -> Position:
    x, y, z = (round(round(float(value) / _STEP) * _STEP, 4) + 0.0 for value in values)
    return x, y, z


def tool_places(arm: Arm, positions: Array) -> Array:
    """Return where the last link of an arm is, (n, 3) [m] in the frame of the robot's base.

    positions: (n, n_joints), of the arm's joints [rad or m].
    """
    points = np.zeros((len(positions), 3))
    for frame in reversed(arm.frames):
        if frame.joint in arm.joints:
            axis = np.asarray(frame.axis)
            position = positions[:, [arm.joints.index(frame.joint)]]
            if frame.slides:
                points = points + position * axis
            else:
                # Rodrigues' formula, for a turn of its own of each point.
                sine, cosine = np.sin(position), np.cos(position)
                along = (points @ axis)[:, None] * axis
                across = points @ _skew(frame.axis).T
                points = points * cosine + across * sine + along * (1.0 - cosine)
        points = points @ _rotation(frame.rpy).T + np.asarray(frame.xyz_m)
    return points


# An arm has few frames, and a run asks for its tool at each of its rests.
_rotation = lru_cache(maxsize=256)(rotation)
_skew = lru_cache(maxsize=256)(skew)
