"""Messages of geometry_msgs under a TransformStamped.

Each result has the header of the transform: the target frame, at the time of the transform.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
from geometry_msgs.msg import (
    Point32,
    PointStamped,
    PolygonStamped,
    Pose,
    PoseStamped,
    PoseWithCovarianceStamped,
    Vector3Stamped,
    WrenchStamped,
)
from tf2_ros import ConvertRegistration, TransformRegistration

from tracerisk.ros.messages.dialect import is_ros2
from tracerisk.ros.transforms import poses
from tracerisk.twin.physics import motion

_IS_ROS2 = is_ros2(Pose)


def to_msg_msg(msg: Any) -> Any:
    """Return the message itself."""
    return msg


def from_msg_msg(msg: Any) -> Any:
    """Return the message itself."""
    return msg


def transform_to_kdl(t: Any) -> Any:
    """Return the frame of PyKDL of a TransformStamped."""
    import PyKDL  # most controllers have no use for it

    frame = _frame(t)
    return PyKDL.Frame(PyKDL.Rotation.Quaternion(*frame.orientation), PyKDL.Vector(*frame.position))


def do_transform_point(point: Any, transform: Any) -> Any:
    """Return a PointStamped in the target frame."""
    result = PointStamped()
    result.point.x, result.point.y, result.point.z = _point(point.point, _frame(transform))
    return _headed(result, transform)


def do_transform_vector3(vector3: Any, transform: Any) -> Any:
    """Return a Vector3Stamped in the target frame: turned, not shifted."""
    result = Vector3Stamped()
    _turn_into(result.vector, vector3.vector, transform)
    return _headed(result, transform)


def do_transform_pose(pose: Any, transform: Any) -> Any:
    """Return a pose in the target frame.

    ROS 1 and ROS 2 before Humble take and return a PoseStamped, Humble and later a Pose.
    """
    if isinstance(pose, Pose):
        result = Pose()
        _fill_pose(result, pose, _frame(transform))
        return result
    return do_transform_pose_stamped(pose, transform)


def do_transform_pose_stamped(pose: Any, transform: Any) -> Any:
    """Return a PoseStamped in the target frame."""
    result = PoseStamped()
    _fill_pose(result.pose, pose.pose, _frame(transform))
    return _headed(result, transform)


def do_transform_pose_with_covariance_stamped(pose: Any, transform: Any) -> Any:
    """Return a PoseWithCovarianceStamped in the target frame, its covariance turned with it."""
    result = PoseWithCovarianceStamped()
    _fill_pose(result.pose.pose, pose.pose.pose, _frame(transform))
    result.pose.covariance = transform_covariance(pose.pose.covariance, transform)
    return _headed(result, transform)


def do_transform_polygon_stamped(polygon: Any, transform: Any) -> Any:
    """Return a PolygonStamped in the target frame."""
    result = PolygonStamped()
    frame = _frame(transform)
    points = []
    for point in polygon.polygon.points:
        moved = Point32()
        moved.x, moved.y, moved.z = _point(point, frame)
        points.append(moved)
    result.polygon.points = points
    return _headed(result, transform)


def do_transform_wrench(wrench: Any, transform: Any) -> Any:
    """Return a WrenchStamped in the target frame: force and torque turned, not shifted."""
    result = WrenchStamped()
    _turn_into(result.wrench.force, wrench.wrench.force, transform)
    _turn_into(result.wrench.torque, wrench.wrench.torque, transform)
    return _headed(result, transform)


def transform_covariance(cov_in: Any, transform: Any) -> Any:
    """Return a covariance of position and rotation (36 values, by rows) after a turn: R C R^T."""
    turn = _frame(transform).orientation
    matrix = np.zeros((6, 6))
    columns = [poses.rotate(turn, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    matrix[:3, :3] = matrix[3:, 3:] = np.array(columns).T
    covariance = np.array(cov_in, dtype=np.float64).reshape(6, 6)
    return (matrix @ covariance @ matrix.T).ravel().tolist()


def _headed(result: Any, transform: Any) -> Any:
    result.header = deepcopy(transform.header)
    return result


def _frame(transform: Any) -> motion.Pose:
    shift, turn = transform.transform.translation, transform.transform.rotation
    # A message that was never filled turns by a quaternion of length 0, as KDL's, by nothing.
    return motion.Pose(
        (shift.x, shift.y, shift.z), poses.unit_quaternion((turn.x, turn.y, turn.z, turn.w))
    )


def _point(point: Any, frame: motion.Pose) -> tuple[float, float, float]:
    x, y, z = poses.rotate(frame.orientation, (point.x, point.y, point.z))
    fx, fy, fz = frame.position
    return (fx + x, fy + y, fz + z)


def _turn_into(result: Any, vector: Any, transform: Any) -> None:
    turn = _frame(transform).orientation
    result.x, result.y, result.z = poses.rotate(turn, (vector.x, vector.y, vector.z))


def _fill_pose(result: Any, pose: Any, frame: motion.Pose) -> None:
    place, turn = pose.position, pose.orientation
    given = motion.Pose(
        (place.x, place.y, place.z), poses.unit_quaternion((turn.x, turn.y, turn.z, turn.w))
    )
    moved = poses.compose(frame, given)
    result.position.x, result.position.y, result.position.z = moved.position
    # The library of ROS 2 goes over matrices, which leaves of the two signs the one with w >= 0.
    sign = -1.0 if _IS_ROS2 and moved.orientation[3] < 0 else 1.0
    turn = result.orientation
    turn.x, turn.y, turn.z, turn.w = (sign * value for value in moved.orientation)


for _kind in (PointStamped, PoseStamped, Vector3Stamped):
    ConvertRegistration().add_to_msg(_kind, to_msg_msg)
    ConvertRegistration().add_from_msg(_kind, from_msg_msg)
for _kind, _function in (
    (PointStamped, do_transform_point),
    (PolygonStamped, do_transform_polygon_stamped),
    (PoseStamped, do_transform_pose_stamped),
    (PoseWithCovarianceStamped, do_transform_pose_with_covariance_stamped),
    (Vector3Stamped, do_transform_vector3),
    (WrenchStamped, do_transform_wrench),
):
    TransformRegistration().add(_kind, _function)
