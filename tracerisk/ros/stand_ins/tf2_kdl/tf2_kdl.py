"""Values of PyKDL under a TransformStamped; each result has the header of the transform."""

from __future__ import annotations

from typing import Any

import PyKDL
from geometry_msgs.msg import PointStamped, PoseStamped
from tf2_geometry_msgs import transform_to_kdl
from tf2_ros import ConvertRegistration, Stamped, TransformRegistration

from tracerisk.ros.imports.exported import defined as _defined


def do_transform_vector(vector: Any, transform: Any) -> Any:
    """Return a vector in the target frame."""
    moved = transform_to_kdl(transform) * vector
    moved.header = transform.header
    return moved


do_transform_frame = do_transform_twist = do_transform_wrench = do_transform_vector


def to_msg_vector(vector: Any) -> Any:
    """Return the PointStamped of a vector that has a header."""
    message = PointStamped(header=vector.header)
    message.point.x, message.point.y, message.point.z = vector
    return message


def from_msg_vector(msg: Any) -> Any:
    """Return the vector of a PointStamped, with its header."""
    vector = PyKDL.Vector(msg.point.x, msg.point.y, msg.point.z)
    return Stamped(vector, msg.header.stamp, msg.header.frame_id)


def to_msg_frame(f: Any) -> Any:
    """Return the PoseStamped of a frame that has a header."""
    message = PoseStamped(header=f.header)
    place, turn = message.pose.position, message.pose.orientation
    place.x, place.y, place.z = f.p
    turn.x, turn.y, turn.z, turn.w = f.M.GetQuaternion()
    return message


def from_msg_frame(msg: Any) -> Any:
    """Return the frame of a PoseStamped, with its header."""
    frame = _frame(msg.pose.position, msg.pose.orientation)
    return Stamped(frame, msg.header.stamp, msg.header.frame_id)


def _frame(place: Any, turn: Any) -> Any:
    return PyKDL.Frame(
        PyKDL.Rotation.Quaternion(turn.x, turn.y, turn.z, turn.w),
        PyKDL.Vector(place.x, place.y, place.z),
    )


for _kind in (PyKDL.Vector, PyKDL.Frame, PyKDL.Twist, PyKDL.Wrench):
    TransformRegistration().add(_kind, do_transform_vector)
ConvertRegistration().add_to_msg(PyKDL.Vector, to_msg_vector)
ConvertRegistration().add_from_msg(PyKDL.Vector, from_msg_vector)
ConvertRegistration().add_to_msg(PyKDL.Frame, to_msg_frame)
ConvertRegistration().add_from_msg(PyKDL.Frame, from_msg_frame)


__all__ = _defined(globals(), "transform_to_kdl")
