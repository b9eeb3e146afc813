"""A gripper (ROS 1)."""

from __future__ import annotations

from typing import Any

import rospy

from ._gripper import GripperInterface
from .core import InterbotixRobotXSCore

__all__ = ["InterbotixGripperXS", "InterbotixGripperXSInterface"]


class InterbotixGripperXS:
    """A gripper without its arm: `dxl` the driver, `gripper` its interface."""

    def __init__(
        self,
        robot_model: str,
        gripper_name: str,
        robot_name: str | None = None,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
        init_node: bool = True,
    ) -> None:
        self.dxl = InterbotixRobotXSCore(robot_model, robot_name, init_node)
        self.gripper = InterbotixGripperXSInterface(
            self.dxl,
            gripper_name,
            gripper_pressure,
            gripper_pressure_lower_limit,
            gripper_pressure_upper_limit,
        )


class InterbotixGripperXSInterface(GripperInterface):
    """Opens and closes a gripper with a pressure."""

    def __init__(
        self,
        core: InterbotixRobotXSCore,
        gripper_name: str,
        gripper_pressure: float = 0.5,
        gripper_pressure_lower_limit: int = 150,
        gripper_pressure_upper_limit: int = 350,
    ) -> None:
        self.core = core
        info = core.robot_get_robot_info("single", gripper_name)
        if info.mode not in ("current", "pwm"):
            rospy.logerr("Please set the gripper's 'operating mode' to 'pwm' or 'current'.")
        self._begin(
            "gripper", gripper_pressure, gripper_pressure_lower_limit, gripper_pressure_upper_limit
        )
        self._take_info(info)
        rospy.Timer(rospy.Duration(0.02), self.gripper_state)
        print(  # noqa: T201
            f"Gripper Name: {gripper_name}\nGripper Pressure: {gripper_pressure * 100:.0f}%"
        )
        print("Initialized InterbotixGripperXSInterface!\n")  # noqa: T201

    def gripper_state(self, event: Any) -> None:
        """Stop fingers that are at their limit."""
        self._look()

    def open(self, delay: float = 1.0) -> None:
        """Open the gripper and wait [s]."""
        self.gripper_controller(self.gripper_value, delay)

    def close(self, delay: float = 1.0) -> None:
        """Close the gripper and wait [s]."""
        self.gripper_controller(-self.gripper_value, delay)
