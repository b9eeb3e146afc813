"""Rotations, as the library writes them: euler angles are yaw, pitch and roll."""

from __future__ import annotations

from typing import Any

import numpy as np
from tf.transformations import (
    euler_from_quaternion,
    quaternion_from_euler,
    quaternion_from_matrix,
    quaternion_matrix,
)

from tracerisk.ros.imports.exported import defined as _defined


def try_cv2_import() -> Any:
    """Return OpenCV's module, which the library imports past ROS's own."""
    import cv2

    return cv2


def euler_to_quat(euler: Any) -> Any:
    """Return the quaternion of yaw, pitch and roll [rad]."""
    yaw, pitch, roll = np.asarray(euler, dtype=float).flatten()
    return np.array(quaternion_from_euler(yaw, pitch, roll, "rzyx"))


def quat_to_rot_mat(quat: Any) -> Any:
    """Return the rotation (3, 3) of a quaternion."""
    return np.array(quaternion_matrix(np.asarray(quat, dtype=float)))[:3, :3]


def rot_mat_to_quat(rot: Any) -> Any:
    """Return the quaternion of a rotation (3, 3)."""
    whole = np.identity(4)
    whole[:3, :3] = np.asarray(rot, dtype=float).reshape(3, 3)
    return np.array(quaternion_from_matrix(whole))


def quat_to_euler(quat: Any) -> Any:
    """Return yaw, pitch and roll [rad] of a quaternion."""
    return np.array(euler_from_quaternion(np.asarray(quat, dtype=float), "rzyx"))


def euler_to_rot_mat(euler: Any) -> Any:
    """Return the rotation (3, 3) of yaw, pitch and roll [rad]."""
    return quat_to_rot_mat(euler_to_quat(euler))


def rot_mat_to_euler(rot: Any) -> Any:
    """Return yaw, pitch and roll [rad] of a rotation (3, 3)."""
    return quat_to_euler(rot_mat_to_quat(rot))


def quaternion_of(orientation: Any) -> Any:
    """Return the quaternion of a quaternion, of euler angles or of a rotation.

    Raises:
        TypeError: it is none of these.
    """
    orientation = np.asarray(orientation, dtype=float)
    makers: dict[int, Any] = {4: np.ravel, 3: euler_to_quat, 9: rot_mat_to_quat}
    made = makers.get(orientation.size)
    if made is None:
        raise TypeError(
            "Orientation must be in one of the following forms: rotation matrix, euler angles, "
            "or quaternion"
        )
    return np.asarray(made(orientation))


__all__ = _defined(globals())
