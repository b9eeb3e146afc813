"""Poses and turns: composition, inversion, and the fixed-axis roll, pitch, yaw of ROS.

Quaternions are (x, y, z, w). Formulas: Diebel, Representing Attitude, 2006.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from tracerisk.twin.physics.motion import Pose

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
UNIT_LENGTH = 1e-3
"""How far the length of a unit quaternion may be from 1."""
ORIGIN = Pose((0.0, 0.0, 0.0), IDENTITY)


def unit_quaternion(values: Sequence[float]) -> Quaternion:
    """Return the quaternion at length 1; that of length 0, a message's default, is no turn."""
    x, y, z, w = (float(value) for value in values)
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if length < 1e-9:
        return IDENTITY
    return (x / length, y / length, z / length, w / length)


def goal_quaternion(values: Sequence[float]) -> Quaternion:
    """Return the quaternion that MoveIt takes of an orientation goal or constraint.

    One whose length is not 1 within 0.001 is no turn, whatever it means. Source: moveit/moveit and
    moveit/moveit2, moveit_core/kinematic_constraints/src/kinematic_constraint.cpp.
    """
    length = math.sqrt(sum(float(value) ** 2 for value in values))
    return unit_quaternion(values) if abs(length - 1.0) <= UNIT_LENGTH else IDENTITY


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the turn `b` followed by the turn `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(turn: Quaternion, vector: Sequence[float]) -> Vector:
    """Return a vector after a turn."""
    x, y, z = (float(value) for value in vector)
    rx, ry, rz, _ = multiply(multiply(turn, (x, y, z, 0.0)), conjugate(turn))
    return (rx, ry, rz)


def conjugate(turn: Quaternion) -> Quaternion:
    """Return the turn back."""
    x, y, z, w = turn
    return (-x, -y, -z, w)


def compose(frame: Pose, pose: Pose) -> Pose:
    """Return a pose given in `frame` in the frame that `frame` is given in."""
    x, y, z = rotate(frame.orientation, pose.position)
    fx, fy, fz = frame.position
    return Pose((fx + x, fy + y, fz + z), multiply(frame.orientation, pose.orientation))


def inverse(pose: Pose) -> Pose:
    """Return the pose that undoes `pose`."""
    back = conjugate(pose.orientation)
    x, y, z = rotate(back, pose.position)
    return Pose((-x, -y, -z), back)


def angle_between(a: Quaternion, b: Quaternion) -> float:
    """Return the angle of the turn from `a` to `b`, in [0, pi] [rad]."""
    x, y, z, w = multiply(conjugate(a), b)
    return 2.0 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def quaternion_from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the turn by roll, pitch and yaw about the fixed axes x, y, z [rad]."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def quaternion_from_columns(
    first: Sequence[float], second: Sequence[float], third: Sequence[float]
) -> Quaternion:
    """Return the turn of a rotation matrix with these columns.

    Of its elements the largest is taken first (Shepperd, Quaternion from rotation matrix, 1978).
    """
    (a, d, g), (b, e, h), (c, f, i) = first, second, third
    squares = (1 + a - e - i, 1 - a + e - i, 1 - a - e + i, 1 + a + e + i)
    rows = (
        (squares[0], b + d, c + g, h - f),
        (b + d, squares[1], f + h, c - g),
        (c + g, f + h, squares[2], d - b),
        (h - f, c - g, d - b, squares[3]),
    )
    return unit_quaternion(rows[squares.index(max(squares))])


def rpy_from_quaternion(turn: Quaternion) -> Vector:
    """Return roll, pitch and yaw about the fixed axes x, y, z [rad]; roll is 0 at the poles."""
    x, y, z, w = turn
    sine = 2.0 * (w * y - z * x)
    if abs(sine) > 1.0 - 1e-12:
        # Only yaw -+ roll is defined here.
        return (0.0, math.copysign(math.pi / 2, sine), 2.0 * math.atan2(z, w))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return (roll, math.asin(sine), yaw)


def shifted(pose: Pose, by: Pose) -> Pose:
    """Return a pose that is shifted, and turned where it is, in the axes of its parent."""
    x, y, z = (a + b for a, b in zip(pose.position, by.position, strict=True))
    return Pose((x, y, z), multiply(by.orientation, pose.orientation))
