"""Controllers that the bring-up of a known driver loads, and which of them it starts.

Sources: ROS 2, UniversalRobots/Universal_Robots_ROS2_Driver
ur_robot_driver/launch/ur_control.launch.py and ur_robot_driver/config/ur_controllers.yaml, branches
humble and jazzy; ROS 1, UniversalRobots/Universal_Robots_ROS_Driver
ur_robot_driver/launch/ur5e_bringup.launch and ur_robot_driver/config/ur5e_controllers.yaml.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot


@dataclass(frozen=True, slots=True)
class BringUp:
    """What a driver's bring-up does with controllers, where nothing else is asked of it."""

    driver: str
    """The package whose launch file it is."""
    active: Mapping[str, str]
    """The controllers that it starts, each with its type."""
    inactive: Mapping[str, str]
    """The controllers that it loads without starting them, each with its type."""
    idle: frozenset[str]
    """Those of both that command no joints."""


_UR_2 = BringUp(
    "ur_robot_driver",
    {
        "scaled_joint_trajectory_controller": "ur_controllers/ScaledJointTrajectoryController",
        "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
        "io_and_status_controller": "ur_controllers/GPIOController",
        "speed_scaling_state_broadcaster": "ur_controllers/SpeedScalingStateBroadcaster",
        "force_torque_sensor_broadcaster": (
            "force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster"
        ),
    },
    {
        "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
        "forward_velocity_controller": "velocity_controllers/JointGroupVelocityController",
        "forward_position_controller": "position_controllers/JointGroupPositionController",
        "forward_effort_controller": "forward_command_controller/ForwardCommandController",
        "passthrough_trajectory_controller": "ur_controllers/PassthroughTrajectoryController",
        "force_mode_controller": "ur_controllers/ForceModeController",
        "freedrive_mode_controller": "ur_controllers/FreedriveModeController",
        "tool_contact_controller": "ur_controllers/ToolContactController",
    },
    frozenset(
        {
            "joint_state_broadcaster",
            "io_and_status_controller",
            "speed_scaling_state_broadcaster",
            "force_torque_sensor_broadcaster",
            "force_mode_controller",
            "freedrive_mode_controller",
            "tool_contact_controller",
        }
    ),
)
_UR_1 = BringUp(
    "ur_robot_driver",
    {
        "scaled_pos_joint_traj_controller": "position_controllers/ScaledJointTrajectoryController",
        "joint_state_controller": "joint_state_controller/JointStateController",
        "speed_scaling_state_controller": "scaled_controllers/SpeedScalingStateController",
        "force_torque_sensor_controller": (
            "force_torque_sensor_controller/ForceTorqueSensorController"
        ),
    },
    {
        "pos_joint_traj_controller": "position_controllers/JointTrajectoryController",
        "joint_group_vel_controller": "velocity_controllers/JointGroupVelocityController",
    },
    frozenset(
        {
            "joint_state_controller",
            "speed_scaling_state_controller",
            "force_torque_sensor_controller",
        }
    ),
)


def bring_up_of(robot: Robot, *, is_ros2: bool) -> BringUp | None:
    """Return the bring-up of the driver whose controllers a robot has, if it is known."""
    made = _UR_2 if is_ros2 else _UR_1
    first = next(iter(made.active))
    return made if any(each.name == first for each in robot.controllers) else None
