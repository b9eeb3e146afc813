"""Messages made of the forms in which the library takes poses, positions and joint states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from moveit_msgs.action import ExecuteTrajectory
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


def point(value: Any) -> Any:
    """Return a Point of one, or of three numbers."""
    if isinstance(value, Point):
        return value
    x, y, z = (float(each) for each in value)
    return Point(x=x, y=y, z=z)


def quaternion(value: Any) -> Any:
    """Return a Quaternion of one, or of four numbers."""
    if isinstance(value, Quaternion):
        return value
    x, y, z, w = (float(each) for each in value)
    return Quaternion(x=x, y=y, z=z, w=w)


def stamped(pose: Any, position: Any, quat_xyzw: Any, frame_id: str, stamp: Any) -> Any:
    """Return a PoseStamped of a pose in either form, or of a position and a quaternion."""
    if isinstance(pose, PoseStamped):
        return pose
    if not isinstance(pose, Pose):
        pose = Pose(position=point(position), orientation=quaternion(quat_xyzw))
    return PoseStamped(header=Header(stamp=stamp, frame_id=frame_id), pose=pose)


def init_joint_state(
    joint_names: Sequence[str],
    joint_positions: Sequence[float] | None = None,
    joint_velocities: Sequence[float] | None = None,
    joint_effort: Sequence[float] | None = None,
) -> Any:
    """Return a JointState; what is left out is 0."""
    rest = [0.0] * len(joint_names)
    return JointState(
        name=list(joint_names),
        position=list(joint_positions) if joint_positions is not None else rest,
        velocity=list(joint_velocities) if joint_velocities is not None else rest,
        effort=list(joint_effort) if joint_effort is not None else rest,
    )


def init_execute_trajectory_goal(joint_trajectory: Any) -> Any:
    """Return the goal that executes a trajectory, None where there is none."""
    if joint_trajectory is None:
        return None
    goal = ExecuteTrajectory.Goal()
    goal.trajectory.joint_trajectory = joint_trajectory
    return goal


def init_dummy_joint_trajectory_from_state(
    joint_state: Any, duration_sec: int = 0, duration_nanosec: int = 0
) -> Any:
    """Return a trajectory of one point."""
    trajectory = JointTrajectory(joint_names=joint_state.name)
    reached = JointTrajectoryPoint(
        positions=joint_state.position,
        velocities=joint_state.velocity,
        effort=joint_state.effort,
    )
    reached.time_from_start.sec = int(duration_sec)
    reached.time_from_start.nanosec = int(duration_nanosec)
    trajectory.points = [reached]
    return trajectory
