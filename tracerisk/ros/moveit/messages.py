"""The twin's data as messages of moveit_msgs; `new` makes an empty message `package/Name`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.moveit.scene.planning_scene import SHAPES, PlanningScene, SceneObject, SeenScene
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.physics.motion import JointTrajectory, Pose

New = Callable[[str], Any]

_SPHERE = 2  # shape_msgs/SolidPrimitive
_POSES = tuple(zip(SHAPES[::2], SHAPES[1::2], strict=True))


def new_message(name: str) -> Any:
    """Return an empty message of the classes that programs import."""
    package, _, kind = name.partition("/")
    return getattr(import_module(f"{package}.msg"), kind)()


def joint_constraint(name: str, position: float, tolerance: float, weight: float = 1.0) -> Any:
    """Return the JointConstraint that holds a joint to a position, to a tolerance both ways."""
    made = new_message("moveit_msgs/JointConstraint")
    made.joint_name, made.position, made.weight = name, position, weight
    made.tolerance_above = made.tolerance_below = tolerance
    return made


def position_constraint(
    frame: str, link: str, place: Any, radius: float, weight: float = 1.0
) -> Any:
    """Return the PositionConstraint that holds a link to a sphere about a Pose of a frame."""
    made = new_message("moveit_msgs/PositionConstraint")
    made.header.frame_id, made.link_name, made.weight = frame, link, weight
    sphere = new_message("shape_msgs/SolidPrimitive")
    sphere.type, sphere.dimensions = _SPHERE, [radius]
    made.constraint_region.primitives = [sphere]
    made.constraint_region.primitive_poses = [place]
    return made


def orientation_constraint(
    frame: str, link: str, orientation: Any, tolerances: Sequence[float], weight: float = 1.0
) -> Any:
    """Return the OrientationConstraint that holds a link to a Quaternion, about each axis."""
    made = new_message("moveit_msgs/OrientationConstraint")
    made.header.frame_id, made.link_name, made.weight = frame, link, weight
    made.orientation = orientation
    for axis, tolerance in zip("xyz", tolerances, strict=True):
        setattr(made, f"absolute_{axis}_axis_tolerance", tolerance)
    return made


def set_pose(message: Any, pose: Pose) -> None:
    """Set a geometry_msgs/Pose."""
    p, q = message.position, message.orientation
    p.x, p.y, p.z = pose.position
    q.x, q.y, q.z, q.w = pose.orientation


def state_message(new: New, positions: Mapping[str, float], frame: str, now_ns: int) -> Any:
    """Return joint positions as a RobotState at a time of the run [ns]."""
    state = new("moveit_msgs/RobotState")
    state.joint_state.header.frame_id = frame
    set_time(state.joint_state.header.stamp, EPOCH_NS + now_ns)
    state.joint_state.name = list(positions)
    state.joint_state.position = [float(value) for value in positions.values()]
    return state


def trajectory_message(new: New, trajectory: JointTrajectory, frame: str) -> Any:
    """Return a trajectory as a RobotTrajectory, with the accelerations between its points."""
    message = new("moveit_msgs/RobotTrajectory")
    joint_trajectory = message.joint_trajectory
    joint_trajectory.header.frame_id = frame
    joint_trajectory.joint_names = list(trajectory.joints)
    acceleration = np.zeros_like(trajectory.velocity)
    if len(trajectory.time) > 1:
        acceleration = np.gradient(trajectory.velocity, trajectory.time, axis=0)
    points = []
    for time, position, velocity, change in zip(
        trajectory.time, trajectory.position, trajectory.velocity, acceleration, strict=True
    ):
        point = new("trajectory_msgs/JointTrajectoryPoint")
        point.positions, point.velocities = position.tolist(), velocity.tolist()
        point.accelerations = change.tolist()
        set_time(point.time_from_start, round(float(time) * 1e9))
        points.append(point)
    joint_trajectory.points = points
    return message


def object_message(new: New, item: SceneObject, frame: str, *, with_shapes: bool = True) -> Any:
    """Return an object of the planning scene as a CollisionObject in a frame."""
    message = new("moveit_msgs/CollisionObject")
    message.id = item.name
    message.header.frame_id = frame
    set_pose(message.pose, item.pose)
    for field in SHAPES if with_shapes else ():
        setattr(message, field, list(getattr(item.message, field)))
    fill_poses(message, lambda: new("geometry_msgs/Pose"))
    return message


def fill_poses(message: Any, new_pose: Callable[[], Any]) -> None:
    """Give each shape of a CollisionObject a pose, as MoveIt does in what it answers."""
    for shapes, poses in _POSES:
        given = list(getattr(message, poses))
        for _ in getattr(message, shapes)[len(given) :]:
            pose = new_pose()
            pose.orientation.w = 1.0
            given.append(pose)
        setattr(message, poses, given)


def attached_messages(new: New, scene: PlanningScene | SeenScene) -> list[Any]:
    """Return the attached objects of a scene as AttachedCollisionObjects, sorted by name."""
    result = []
    for _, one in sorted(scene.attached.items()):
        message = new("moveit_msgs/AttachedCollisionObject")
        message.link_name, message.touch_links = one.link, list(one.touch_links)
        message.object = object_message(new, one.object, one.link)
        result.append(message)
    return result
