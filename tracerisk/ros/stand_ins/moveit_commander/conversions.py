"""Poses as messages and as lists of numbers, messages as bytes, and the twin's data as messages."""

from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from typing import Any

import numpy as np
from genpy import Duration, Time
from geometry_msgs.msg import Pose, PoseStamped, Transform
from moveit_msgs.msg import RobotTrajectory
from trajectory_msgs.msg import JointTrajectoryPoint

from tracerisk.ros.moveit.messages import new_message, state_message
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.transforms.poses import Quaternion, quaternion_from_rpy, unit_quaternion
from tracerisk.twin.physics import motion

from ._server import server
from .exception import MoveItCommanderException


def msg_to_string(msg: Any) -> bytes:
    """Return the bytes of a message."""
    buffer = BytesIO()
    msg.serialize(buffer)
    return buffer.getvalue()


def msg_from_string(msg: Any, data: bytes) -> None:
    """Set a message from bytes."""
    msg.deserialize(data)


def pose_to_list(pose_msg: Any) -> list[float]:
    """Return a Pose as [x, y, z, qx, qy, qz, qw]."""
    return [*_vector(pose_msg.position), *_quaternion(pose_msg.orientation)]


def list_to_pose(pose_list: Sequence[float]) -> Any:
    """Return [x, y, z, qx, qy, qz, qw] or [x, y, z, roll, pitch, yaw] as a Pose.

    Raises:
        MoveItCommanderException: there are neither 7 nor 6 values.
    """
    if len(pose_list) not in (6, 7):
        raise MoveItCommanderException(
            "Expected either 6 or 7 elements in list: (x,y,z,r,p,y) or (x,y,z,qx,qy,qz,qw)"
        )
    turn = pose_list[3:]
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = pose_list[:3]
    x, y, z, w = quaternion_from_rpy(*turn) if len(turn) == 3 else turn
    pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w = x, y, z, w
    return pose


def list_to_pose_stamped(pose_list: Sequence[float], target_frame: str) -> Any:
    """Return a list as a PoseStamped in a frame, now."""
    stamped = PoseStamped()
    stamped.pose = list_to_pose(pose_list)
    stamped.header.frame_id = target_frame
    stamped.header.stamp = _now()
    return stamped


def transform_to_list(trf_msg: Any) -> list[float]:
    """Return a Transform as [x, y, z, qx, qy, qz, qw]."""
    return [*_vector(trf_msg.translation), *_quaternion(trf_msg.rotation)]


def list_to_transform(trf_list: Sequence[float]) -> Any:
    """Return [x, y, z, qx, qy, qz, qw] as a Transform."""
    transform = Transform()
    translation, rotation = transform.translation, transform.rotation
    translation.x, translation.y, translation.z = trf_list[:3]
    rotation.x, rotation.y, rotation.z, rotation.w = trf_list[3:7]
    return transform


def _twin_pose(
    values: Sequence[float], turned: Callable[[Sequence[float]], Quaternion] = unit_quaternion
) -> motion.Pose:
    """Return a list of 7 or 6 numbers as the twin's pose; `turned` makes the turn of the last 4."""
    if len(values) not in (6, 7):
        raise MoveItCommanderException(
            "Pose description expected to consist of either 6 or 7 values"
        )
    x, y, z, *turn = (float(value) for value in values)
    whole = quaternion_from_rpy(*turn) if len(turn) == 3 else turned(turn)
    return motion.Pose((x, y, z), whole)


def _trajectory_message(trajectory: motion.JointTrajectory, frame: str) -> Any:
    """Return the twin's trajectory as a RobotTrajectory."""
    message = RobotTrajectory()
    joint_trajectory = message.joint_trajectory
    joint_trajectory.header.frame_id = frame
    joint_trajectory.joint_names = list(trajectory.joints)
    acceleration = np.zeros_like(trajectory.velocity)
    if len(trajectory.time) > 1:
        acceleration = np.gradient(trajectory.velocity, trajectory.time, axis=0)
    rows = zip(trajectory.time, trajectory.position, trajectory.velocity, acceleration, strict=True)
    for time, position, velocity, change in rows:
        point = JointTrajectoryPoint()
        point.positions, point.velocities = position.tolist(), velocity.tolist()
        point.accelerations = change.tolist()
        point.time_from_start = Duration.from_sec(float(time))
        joint_trajectory.points.append(point)
    return message


def _twin_trajectory(message: Any) -> motion.JointTrajectory:
    """Return a RobotTrajectory as the twin's; an empty one has no joints.

    Raises:
        MoveItCommanderException: a point has more or fewer positions than there are joints.
    """
    names = tuple(message.joint_trajectory.joint_names)
    points = message.joint_trajectory.points
    for number, point in enumerate(points):
        if len(point.positions) != len(names):
            raise MoveItCommanderException(
                f"point {number} of the trajectory has {len(point.positions)} positions for "
                f"{len(names)} joints"
            )
    shape = (len(points), len(names))
    time = np.array([point.time_from_start.to_sec() for point in points], dtype=np.float64)
    position = np.array([point.positions for point in points], dtype=np.float64).reshape(shape)
    if all(len(point.velocities) == len(names) for point in points):
        velocity = np.array([point.velocities for point in points], dtype=np.float64)
    elif len(points) > 1 and (np.diff(time) > 0.0).all():
        velocity = np.asarray(np.gradient(position, time, axis=0))
        velocity[[0, -1]] = 0.0
    else:
        velocity = np.zeros(shape)
    return motion.JointTrajectory(names, time, position, velocity.reshape(shape))


def _state_message(positions: Mapping[str, float], frame: str) -> Any:
    """Return joint positions as a RobotState."""
    state = state_message(new_message, positions, frame, server().now_ns())
    state.multi_dof_joint_state.header.frame_id = frame
    return state


def _now() -> Any:
    return Time(0, EPOCH_NS + server().now_ns())


def _vector(message: Any) -> list[float]:
    return [message.x, message.y, message.z]


def _quaternion(message: Any) -> list[float]:
    return [message.x, message.y, message.z, message.w]
