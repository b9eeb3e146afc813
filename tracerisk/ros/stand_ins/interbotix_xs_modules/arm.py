"""An arm and its gripper (ROS 1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import rospy

from ._arm import ArmInterface, description
from .core import InterbotixRobotXSCore
from .gripper import InterbotixGripperXSInterface

__all__ = ["InterbotixArmXSInterface", "InterbotixManipulatorXS"]


class InterbotixManipulatorXS:
    """An arm by its model: `dxl` the driver, `arm`, and `gripper` where it has a name."""

    def __init__(
        self,
        robot_model: str,
        group_name: str = "arm",
        gripper_name: str | None = "gripper",
        robot_name: str | None = None,
        moving_time: float = 2.0,
        accel_time: float = 0.3,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
        init_node: bool = True,
    ) -> None:
        self.dxl = InterbotixRobotXSCore(robot_model, robot_name, init_node)
        self.arm = InterbotixArmXSInterface(
            self.dxl, robot_model, group_name, moving_time, accel_time
        )
        if gripper_name is not None:
            self.gripper = InterbotixGripperXSInterface(
                self.dxl,
                gripper_name,
                gripper_pressure,
                gripper_pressure_lower_limit,
                gripper_pressure_upper_limit,
            )


class InterbotixArmXSInterface(ArmInterface):
    """Moves an arm by joint positions, poses and lines."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        robot_model: str,
        group_name: str,
        moving_time: float = 2.0,
        accel_time: float = 0.3,
    ) -> None:
        self.core = core
        self.group_info = core.robot_get_robot_info("group", group_name)
        if self.group_info.profile_type != "time":
            rospy.logerr("Please set the group's 'profile type' to 'time'.")
        if self.group_info.mode != "position":
            rospy.logerr("Please set the group's 'operating mode' to 'position'.")
        self.robot_des = description(robot_model)
        self.group_name = group_name
        self._begin(robot_model)
        self.set_trajectory_time(moving_time, accel_time)
        print(  # noqa: T201
            f"Arm Group Name: {group_name}\nMoving Time: {moving_time:.2f} seconds\n"
            f"Acceleration Time: {accel_time:.2f} seconds\nDrive Mode: Time-Based-Profile"
        )
        print("Initialized InterbotixArmXSInterface!\n")  # noqa: T201

    def publish_positions(
        self,
        positions: Sequence[float],
        moving_time: float | None = None,
        accel_time: float | None = None,
        blocking: bool = True,
    ) -> None:
        """Command joint positions without a look at the limits."""
        self._publish(positions, moving_time, accel_time, blocking)

    def check_joint_limits(self, positions: Sequence[float]) -> bool:
        """Return whether positions, and the speeds to get there, are within the limits."""
        if self._is_within(positions):
            return True
        rospy.logwarn("Would exceed position or velocity limits.")
        return False

    def check_single_joint_limit(self, joint_name: str, position: float) -> bool:
        """Return whether the position of a joint, and its speed, are within the limits."""
        return self._is_one_within(joint_name, position)

    def set_relative_ee_position_wrt_to_base_frame(
        self,
        *,
        dx: float = 0,
        dy: float = 0,
        dz: float = 0,
        custom_guess: Any = None,
        execute: bool = True,
        moving_time: float | None = None,
        accel_time: float | None = None,
        blocking: bool = True,
    ) -> tuple[Any, bool]:
        """Bring the end effector to a place [m] from where it was commanded to, level."""
        return self.set_ee_pose_components(
            x=self.T_sb[0, 3] + dx,
            y=self.T_sb[1, 3] + dy,
            z=self.T_sb[2, 3] + dz,
            custom_guess=custom_guess,
            execute=execute,
            moving_time=moving_time,
            accel_time=accel_time,
            blocking=blocking,
        )
