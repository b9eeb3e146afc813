"""Where the tool of an arm was along a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.geometry.frames import rotation

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot

Array = NDArray[np.float64]


def tool_link(robot: Robot, arm: Sequence[str]) -> str:
    """Return the link that an arm's joints carry furthest out: a group's tip, else the last one."""
    joints = set(arm)

    def moved_by(link: str) -> int:
        return sum(1 for hung in robot.above(link) if hung.name in joints)

    most = max(map(moved_by, robot.link_names))
    tips = (group.tip_link for group in robot.groups.values() if joints & set(group.joints))
    named = (tip for tip in tips if tip is not None and moved_by(tip) == most)
    return next(named, next(link for link in robot.link_names if moved_by(link) == most))


def tool_places(robot: Robot, link: str, positions: Mapping[str, Array]) -> Array:
    """Return where a link's origin is, (n, 3) [m] in the base's frame.

    positions: joint name to its positions, (n,) each [rad or m]; others are at 0.
    """
    n = len(next(iter(positions.values())))
    points = np.zeros((n, 3))
    for hung in robot.above(link):
        axis = np.asarray(hung.axis, dtype=np.float64)
        if hung.type != "fixed":
            axis = axis / np.linalg.norm(axis)
            position = positions.get(hung.name, np.zeros(n))[:, None]
            if hung.type == "prismatic":
                points = points + position * axis
            else:
                # Rodrigues' formula, for a turn of its own of each point.
                sine, cosine = np.sin(position), np.cos(position)
                along = (points @ axis)[:, None] * axis
                points = points * cosine + np.cross(axis, points) * sine + along * (1.0 - cosine)
        points = points @ rotation(hung.rpy).T + np.asarray(hung.xyz)
    return points
