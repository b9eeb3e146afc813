"""Numbers of a posture or a pose for a bare list in a message, inferred from the list's name."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from tracerisk.common.geometry.frames import matrix_of
from tracerisk.ros.drafts.named_numbers import SI, Units
from tracerisk.twin.physics.motion import Pose

_JOINTS = re.compile(
    r"^data$|(^|_)(joints?|(joint_?)?(pos(itions?)?|values|angles|states?|goals?|targets?))$|"
    r"^(j|q|joints?_\w+)$",
    re.IGNORECASE,
)
_NO_PLACE = re.compile(
    r"vel|acc|eff|force|torque|speed|stiff|damp|tol|limit|weight|gain|duration|time|offset|size|"
    r"scale|axis|direction|normal|error",
    re.IGNORECASE,
)
_TURN = re.compile(r"orient|quat|rot", re.IGNORECASE)
_ANGLES = re.compile(r"orient|rot|rpy|euler", re.IGNORECASE)
_POINT = re.compile(
    r"pos|point|xyz|target|goal|cent(er|re)|translation|place|locat|coord|object", re.IGNORECASE
)
_POSE = re.compile(r"(^|_)pose$|euler_?pos|cartesian|xyz_?rpy|tcp", re.IGNORECASE)
_UPWARDS = re.compile(r"(^|_)(approach(es)?|normals?|direction|ax[ie]s)(_|$)", re.IGNORECASE)
_NO_VECTOR = re.compile(r"pos|point|pose|place|dist|joint", re.IGNORECASE)
_MATRIX = 16
# As libfranka names them: column by column, of the tool in the frame of the base.
_OF_TOOL = re.compile(r"^O_T_")
_ANY_MATRIX = re.compile(r"^data$|matrix|transf|(^|_)(tf|pose)(_|$)", re.IGNORECASE)
_OF_PARTS = re.compile(r"^[A-Z]+_T_[A-Z]+$")


def says_no_place(name: str) -> bool:
    """Return whether a list of this name holds no joints and no pose: speeds, forces, limits."""
    return _NO_PLACE.search(name) is not None


def numbers_of(
    name: str,
    length: int | None,
    posture: Sequence[float],
    pose: Pose,
    units: Units = SI,
) -> list[float]:
    """Return the numbers of a list called `name`, of joints or of a pose, in units; [] for none.

    `length` is that of a fixed list. A pose is x, y, z and, where there is room, the turn: as a
    quaternion of four numbers or as roll, pitch and yaw.
    """
    if length == len("xyz") and _UPWARDS.search(name) and not _NO_VECTOR.search(name):
        return [0.0, 0.0, 1.0]
    if says_no_place(name):
        return []
    if length == _MATRIX and (_OF_PARTS.match(name) or _ANY_MATRIX.search(name)):
        return _matrix(name, pose)
    if "joint" not in name.lower():
        numbers = _of_pose(name, length, pose, units)
        if numbers:
            return numbers
    if not _JOINTS.search(name):
        return []
    angles = [units.angle(value) for value in posture]
    if length in (None, len(posture)):
        return angles
    return (angles + [0.0] * length)[:length]


def _of_pose(name: str, length: int | None, pose: Pose, units: Units) -> list[float]:
    position = [units.length(value) for value in pose.position]
    turn = list(pose.orientation)
    if length == len(turn) and _TURN.search(name):
        return turn
    angles = [units.angle(round(value, 4) + 0.0) for value in roll_pitch_yaw(pose.orientation)]
    if length == len(angles) and _ANGLES.search(name):
        return angles
    if length == len(position) and _POINT.search(name):
        return position
    if not _POSE.search(name):
        return []
    if length == len(position) + len(turn):
        return position + turn
    return position + angles if length in (None, 6) else []


def _matrix(name: str, pose: Pose) -> list[float]:
    """Return the 16 numbers of a pose as a matrix, row by row; [] where the name says no pose."""
    rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    is_of_tool = _OF_TOOL.match(name) is not None
    if is_of_tool or not _OF_PARTS.match(name):
        *vector, w = pose.orientation
        turns = matrix_of((w, *vector))
        for row, turn, at in zip(rows, turns, pose.position, strict=False):
            row[:] = [*(round(float(value), 6) + 0.0 for value in turn), at]
    if is_of_tool:
        rows = [list(column) for column in zip(*rows, strict=True)]
    return [number for row in rows for number in row]


def roll_pitch_yaw(turn: tuple[float, float, float, float]) -> tuple[float, float, float]:
    """Return the angles [rad] of a quaternion (x, y, z, w), about the fixed axes."""
    x, y, z, w = turn
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, yaw
