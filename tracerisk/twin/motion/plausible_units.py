"""Words for goals out of range, and guesses of their units: degrees for radians, mm for m."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.twin.physics.motion import Pose
    from tracerisk.twin.robots.robot_parts import Joint

_FAR = 100.0  # by how much more than its range a value is that may be in mm
_CLOSE_M = 0.005  # no tool comes as near to the origin of its robot: such a pose may be in m for mm


def shown_limits(joint: Joint, value: float) -> str:
    """Return the limits of a joint, with a guess of the unit of a value that is past them."""
    return f"[{joint.lower:g}, {joint.upper:g}]{unit_guess(joint, value)}"


def past_limits(joint: Joint, value: float, slack: float) -> str:
    """Return in words how a goal is past a joint's limits by more than `slack`; empty if not."""
    if joint.type == "continuous" or joint.lower - slack <= value <= joint.upper + slack:
        return ""
    return f"{value:g}, past its limits {shown_limits(joint, value)}"


def speed_guess(joint: Joint, speed: float) -> str:
    """Return a guess of the unit of a velocity above a joint's limit; empty for none [rad/s]."""
    if abs(speed) <= joint.velocity_limit:
        return ""
    if joint.type == "prismatic":
        return " (mm/s?)" if abs(speed) > _FAR * joint.velocity_limit else ""
    return " (deg/s?)" if math.radians(abs(speed)) <= joint.velocity_limit else ""


def are_radians_likely(joints: Sequence[Joint], goal: Sequence[float]) -> bool:
    """Return whether a goal in degrees may be one in radians.

    It leads several joints hardly away from zero, none by whole degrees alone, and would be within
    their limits in radians.
    """
    moved = [value for value in goal if value]
    if len(moved) < 2 or all(float(value).is_integer() for value in moved):
        return False
    return max(map(abs, moved)) <= 2 * math.pi and all(
        joint.type != "prismatic" and joint.lower <= value <= joint.upper
        for joint, value in zip(joints, goal, strict=False)
    )


def cut_line(goal: Pose, fraction: float, here: Pose) -> str:
    """Return in words how much of the line from `here` to a pose can be followed."""
    x, y, z = goal.position
    guess = length_guess(goal.position, math.hypot(*here.position))
    share = floored_percent(fraction)
    return f"only {share} of the line to ({x:.3f}, {y:.3f}, {z:.3f}) m{guess} can be followed"


def floored_percent(fraction: float) -> str:
    """Return a fraction in per cent, rounded down: what is not whole is not 100 %."""
    return f"{math.floor(100.0 * fraction + 1e-9)}%"


def length_guess(position: Sequence[float], reach_m: float) -> str:
    """Return a guess of the unit of a position in the frame of the base [m]; empty for none.

    `reach_m` is how far from the base the tool is, or can come [m].
    """
    distance = math.hypot(*position)
    if distance > _FAR * max(reach_m, _CLOSE_M):
        return " (mm?)"
    return " (m, where mm are expected?)" if 0.0 < distance < _CLOSE_M else ""


def unit_guess(joint: Joint, value: float) -> str:
    """Return a guess of the unit of a value past a joint's limits; empty for none."""
    furthest = max(abs(joint.lower), abs(joint.upper))
    if joint.type == "prismatic":
        return " (mm?)" if abs(value) > _FAR * furthest else ""
    if max(2 * math.pi, furthest) < abs(value) <= 360.0:
        return " (degrees?)"
    # Nobody gives whole radians, and the others are as likely in radians.
    is_whole = float(value).is_integer() and furthest < abs(value) <= 360.0
    return " (degrees?)" if is_whole and joint.lower <= math.radians(value) <= joint.upper else ""
