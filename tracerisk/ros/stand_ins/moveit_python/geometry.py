"""Poses as matrices, moved and turned."""

from __future__ import annotations

from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion

from tracerisk.ros.homogeneous import turns
from tracerisk.ros.imports.exported import defined as _defined


def matrix_from_point_msg(point: Any) -> Any:
    """Return the matrix (4, 4) of a displacement."""
    return _moved(point.x, point.y, point.z)


def _moved(x: float, y: float, z: float) -> Any:
    matrix = np.identity(4)
    matrix[:3, 3] = x, y, z
    return matrix


def matrix_from_quaternion_msg(quaternion: Any) -> Any:
    """Return the matrix (4, 4) of a turn."""
    q = quaternion
    return np.array(turns.quaternion_matrix([q.x, q.y, q.z, q.w]))


def matrix_from_pose_msg(pose: Any) -> Any:
    """Return the matrix (4, 4) of a pose."""
    return matrix_from_point_msg(pose.position) @ matrix_from_quaternion_msg(pose.orientation)


def point_msg_from_matrix(transformation: Any) -> Any:
    """Return the Point of a matrix (4, 4)."""
    return Point(*(float(transformation[row][3]) for row in range(3)))


def quaternion_msg_from_matrix(transformation: Any) -> Any:
    """Return the Quaternion of a matrix (4, 4)."""
    return Quaternion(*(float(value) for value in turns.quaternion_from_matrix(transformation)))


def pose_msg_from_matrix(transformation: Any) -> Any:
    """Return the Pose of a matrix (4, 4)."""
    place = point_msg_from_matrix(transformation)
    return Pose(place, quaternion_msg_from_matrix(transformation))


def translate_pose_msg(pose: Any, x: float, y: float, z: float) -> Any:
    """Return a pose moved along its own axes [m]."""
    return pose_msg_from_matrix(matrix_from_pose_msg(pose) @ _moved(x, y, z))


def rotate_pose_msg_by_euler_angles(pose: Any, r: float, p: float, y: float) -> Any:
    """Return a pose turned about its own axes [rad]."""
    return pose_msg_from_matrix(matrix_from_pose_msg(pose) @ _turned(r, p, y))


def rotate_pose_msg_about_origin(pose: Any, r: float, p: float, y: float) -> Any:
    """Return a pose turned about the origin [rad]."""
    return pose_msg_from_matrix(_turned(r, p, y) @ matrix_from_pose_msg(pose))


def _turned(r: float, p: float, y: float) -> Any:
    return np.array(turns.euler_matrix(r, p, y))


__all__ = _defined(globals())
