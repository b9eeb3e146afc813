"""Turns and poses as matrices; angles in [rad], lengths in [m]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from geometry_msgs.msg import Quaternion, QuaternionStamped

from tracerisk.common.geometry import screw_kinematics
from tracerisk.ros.homogeneous import turns


def trans_inv(T: Any) -> Any:
    """Return the inverse of a pose (4, 4)."""
    return screw_kinematics.inverted(np.asarray(T, dtype=np.float64))


def yaw_to_rotation_matrix(yaw: float) -> Any:
    """Return a turn in the plane (2, 2)."""
    sine, cosine = math.sin(yaw), math.cos(yaw)
    return np.array([[cosine, -sine], [sine, cosine]])


def pose_to_transformation_matrix(pose: Sequence[float]) -> Any:
    """Return the matrix (4, 4) of x, y, z, roll, pitch, yaw."""
    matrix = np.identity(4)
    matrix[:3, :3] = euler_angles_to_rotation_matrix(pose[3:])
    matrix[:3, 3] = pose[:3]
    return matrix


def euler_angles_to_rotation_matrix(theta: Sequence[float]) -> Any:
    """Return the turn (3, 3) about the fixed x, then y, then z."""
    return turns.euler_matrix(theta[0], theta[1], theta[2], axes="sxyz")[:3, :3]


def euler_angles_to_quaternion(theta: Sequence[float]) -> Any:
    """Return the quaternion (x, y, z, w) of the turn about the fixed x, then y, then z."""
    return turns.quaternion_from_euler(theta[0], theta[1], theta[2], axes="sxyz")


def rotation_matrix_to_euler_angles(R: Any) -> list[float]:
    """Return the angles about the fixed x, then y, then z of a turn (3, 3)."""
    return list(turns.euler_from_matrix(R, axes="sxyz"))


def quaternion_is_valid(quat: Any, tol: float = 10e-3) -> bool:
    """Return whether a quaternion's squares sum to 1.

    Raises:
        TypeError: it is neither a Quaternion nor a QuaternionStamped.
    """
    if isinstance(quat, QuaternionStamped):
        quat = quat.quaternion
    elif not isinstance(quat, Quaternion):
        raise TypeError(
            f"quaternion_is_valid takes a Quaternion or a QuaternionStamped, not {type(quat)}"
        )
    return bool(abs(quat.w**2 + quat.x**2 + quat.y**2 + quat.z**2 - 1.0) < tol)


transInv = trans_inv
yawToRotationMatrix = yaw_to_rotation_matrix
poseToTransformationMatrix = pose_to_transformation_matrix
eulerAnglesToRotationMatrix = euler_angles_to_rotation_matrix
rotationMatrixToEulerAngles = rotation_matrix_to_euler_angles
