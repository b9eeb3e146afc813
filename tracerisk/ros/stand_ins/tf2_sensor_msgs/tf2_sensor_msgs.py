"""Clouds of points under a transform."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
from sensor_msgs.msg import PointCloud2
from sensor_msgs_py.point_cloud2 import dtype_from_fields
from tf2_ros import ConvertRegistration, TransformRegistration

from tracerisk.ros.homogeneous.turns import quaternion_matrix


def to_msg_msg(msg: Any) -> Any:
    """Return the message itself."""
    return msg


def from_msg_msg(msg: Any) -> Any:
    """Return the message itself."""
    return msg


def transform_points(point_cloud: Any, transform: Any) -> Any:
    """Return points in the target frame of a Transform; points: (n, 3), [m]."""
    turn, shift = transform.rotation, transform.translation
    matrix = quaternion_matrix((turn.x, turn.y, turn.z, turn.w))[:3, :3]
    return np.asarray(point_cloud) @ matrix.T + (shift.x, shift.y, shift.z)


def do_transform_cloud(cloud: Any, transform: Any) -> Any:
    """Return a cloud in the target frame of a Transform or TransformStamped.

    Its fields beside `x`, `y` and `z` stay as they are, and so does the header of a Transform.
    """
    header = deepcopy(getattr(transform, "header", cloud.header))
    inner = getattr(transform, "transform", transform)
    kind = dtype_from_fields(cloud.fields, cloud.point_step)
    order = ">" if cloud.is_bigendian else "<"
    points = np.frombuffer(bytes(cloud.data), kind.newbyteorder(order)).copy()
    moved = transform_points(np.stack([points[axis] for axis in "xyz"], axis=-1), inner)
    for index, axis in enumerate("xyz"):
        points[axis] = moved[:, index]
    made = deepcopy(cloud)
    made.header = header
    made.data = points.tobytes()
    return made


ConvertRegistration().add_to_msg(PointCloud2, to_msg_msg)
ConvertRegistration().add_from_msg(PointCloud2, from_msg_msg)
TransformRegistration().add(PointCloud2, do_transform_cloud)
