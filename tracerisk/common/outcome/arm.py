"""The kinematics of an arm as the outcome keeps it: where the tool is for given joints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.common.geometry.rotation import Quaternion, product, quaternion_of, rotated

Position = tuple[float, float, float]

_UNTURNED: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ArmFrame:
    """How one link hangs on the one before, from the base to the tool."""

    xyz_m: Position
    """Its place in the frame before, [m]."""
    rpy: Position
    """Its roll, pitch and yaw about fixed axes there, [rad]."""
    joint: str = ""
    """The joint that moves it; empty for a fixed one."""
    axis: Position = (0.0, 0.0, 1.0)
    """The joint's axis."""
    slides: bool = False
    """Whether the joint shifts it along the axis rather than turning it."""


@dataclass(frozen=True, slots=True)
class Arm:
    """An arm that was commanded."""

    joints: tuple[str, ...]
    """The names of its joints, in the order of the positions of a rest."""
    frames: tuple[ArmFrame, ...] = ()
    """From the robot's base to the tool."""


def tool_pose(arm: Arm, joints: Sequence[float]) -> tuple[Position, Quaternion]:
    """Return place [m] and turn (w, x, y, z) of the tool in the robot's base frame.

    joints: (n_joints,), positions [rad or m]; joints of other arms are at 0.
    """
    at = dict(zip(arm.joints, joints, strict=True))
    place: Position = (0.0, 0.0, 0.0)
    turn = _UNTURNED
    for frame in arm.frames:
        place = _shifted(place, turn, frame.xyz_m)
        turn = product(turn, quaternion_of(frame.rpy))
        position = at.get(frame.joint, 0.0)
        if frame.slides:
            x, y, z = frame.axis
            place = _shifted(place, turn, (x * position, y * position, z * position))
        elif position:
            turn = product(turn, _about(frame.axis, position))
    return place, turn


def angle_between(one: Quaternion, other: Quaternion) -> float:
    """Return the angle of the turn from one orientation to another [rad]."""
    # By the chord, not by the cosine, which says nothing of small angles.
    chord = min(math.dist(one, other), math.dist(one, [-value for value in other]))
    return 4.0 * math.asin(min(1.0, chord / 2.0))


def _shifted(place: Position, turn: Quaternion, by: Position) -> Position:
    x, y, z = (at + shift for at, shift in zip(place, rotated(turn, by), strict=True))
    return x, y, z


def _about(axis: Position, angle: float) -> Quaternion:
    length = math.hypot(*axis) or 1.0
    sine = math.sin(angle / 2.0) / length
    return math.cos(angle / 2.0), axis[0] * sine, axis[1] * sine, axis[2] * sine
