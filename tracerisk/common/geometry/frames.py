"""Rotations as matrices, quaternions, and roll, pitch, yaw about fixed axes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

Triple = tuple[float, float, float]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.float64]]


def triple(values: Iterable[float]) -> Triple:
    """Return three numbers of any kind as floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def rotation(rpy: Triple) -> Matrix:
    """Return the rotation matrix of roll, pitch, yaw about fixed axes [rad]."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def roll_pitch_yaw(turn: Matrix) -> Triple:
    """Return roll, pitch, yaw about fixed axes [rad] of a rotation matrix."""
    pitch = math.asin(min(max(-float(turn[2, 0]), -1.0), 1.0))
    if abs(turn[2, 0]) > 1.0 - 1e-12:
        # Roll and yaw turn about the same axis: all of it is yaw.
        return 0.0, pitch, math.atan2(-float(turn[0, 1]), float(turn[1, 1]))
    roll = math.atan2(float(turn[2, 1]), float(turn[2, 2]))
    return roll, pitch, math.atan2(float(turn[1, 0]), float(turn[0, 0]))


def matrix_of(quaternion: Sequence[float]) -> Matrix:
    """Return the rotation matrix of a quaternion (w, x, y, z)."""
    w, x, y, z = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def skew(vector: Iterable[float]) -> Matrix:
    """Return the matrix (3, 3) that makes the cross product with a vector."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def about(axis: Triple, angle: float) -> Matrix:
    """Return the rotation matrix of a turn by `angle` [rad] about an axis (Rodrigues)."""
    cross = skew(np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis))
    turn: Matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return turn
