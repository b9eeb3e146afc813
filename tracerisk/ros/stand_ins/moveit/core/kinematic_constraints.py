"""Constraints made of poses and states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tracerisk.ros.moveit import messages

from .._library import new
from .robot_model import JointModelGroup
from .robot_state import RobotState

__all__ = [
    "construct_constraints_from_node",
    "construct_joint_constraint",
    "construct_link_constraint",
]


def construct_joint_constraint(
    robot_state: RobotState, joint_model_group: JointModelGroup, tolerance: float = 0.01
) -> Any:
    """Return Constraints that hold a group's joints where a state has them, to a tolerance."""
    if not isinstance(robot_state, RobotState) or not isinstance(
        joint_model_group, JointModelGroup
    ):
        raise TypeError(
            "construct_joint_constraint(): incompatible function arguments. It takes "
            "(robot_state: RobotState, joint_model_group: JointModelGroup, tolerance: float)"
        )
    constraints = new("moveit_msgs/Constraints")
    positions = robot_state.joint_positions
    constraints.joint_constraints = [
        messages.joint_constraint(name, positions[name], float(tolerance))
        for name in joint_model_group.active_joint_model_names
    ]
    return constraints


def construct_link_constraint(
    link_name: str,
    source_frame: str,
    cartesian_position: Sequence[float] | None = None,
    cartesian_position_tolerance: float | None = None,
    orientation: Sequence[float] | None = None,
    orientation_tolerance: float | None = None,
) -> Any:
    """Return Constraints on a link: within a sphere about a position, turned as a quaternion.

    Raises:
        ValueError: neither is given.
        RuntimeError: one is given without its tolerance.
    """
    if cartesian_position is None and orientation is None:
        raise ValueError("No link cartesian or orientation constraints specified")
    constraints = new("moveit_msgs/Constraints")
    if cartesian_position is not None:
        radius = _given(cartesian_position_tolerance)
        constraints.position_constraints = [
            _position(link_name, source_frame, cartesian_position, radius)
        ]
    if orientation is not None:
        tolerance = _given(orientation_tolerance)
        constraints.orientation_constraints = [
            _orientation(link_name, source_frame, orientation, tolerance)
        ]
    return constraints


def construct_constraints_from_node(node_name: Any, ns: str) -> Any:
    """Return the Constraints that a node's parameters describe.

    Raises:
        TypeError: always; the real library takes a node of C++ here, which Python has none of.
    """
    raise TypeError(
        "construct_constraints_from_node(): incompatible function arguments. It takes "
        f"(node_name: rclcpp::Node, ns: str), which Python has none of, not "
        f"{type(node_name).__name__}; make the constraints by construct_joint_constraint or "
        "construct_link_constraint"
    )


def _position(link: str, frame: str, at: Sequence[float], radius: float) -> Any:
    pose = new("geometry_msgs/Pose")
    pose.position.x, pose.position.y, pose.position.z = (float(value) for value in at)
    return messages.position_constraint(frame, link, pose, radius)


def _orientation(link: str, frame: str, turn: Sequence[float], tolerance: float) -> Any:
    q = new("geometry_msgs/Quaternion")
    q.x, q.y, q.z, q.w = (float(value) for value in turn)
    return messages.orientation_constraint(frame, link, q, (tolerance,) * 3)


def _given(tolerance: float | None) -> float:
    if tolerance is None:
        raise RuntimeError("bad optional access")
    return float(tolerance)


def _pose_constraint(pose_stamped: Any, link: str) -> Any:
    """Return Constraints that bring a link to a PoseStamped, to 1 mm and 0.01 rad."""
    p, q = pose_stamped.pose.position, pose_stamped.pose.orientation
    return construct_link_constraint(
        link, pose_stamped.header.frame_id, (p.x, p.y, p.z), 1e-3, (q.x, q.y, q.z, q.w), 1e-2
    )
