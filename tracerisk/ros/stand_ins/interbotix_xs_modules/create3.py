"""The Create 3 base of a LoCoBot (ROS 1)."""

from __future__ import annotations

import rospy

from ._base import BaseInterface

__all__ = ["InterbotixCreate3Interface"]


class InterbotixCreate3Interface(BaseInterface):
    """Drives the base; its sounds and ticks have messages that ROS 1 has from its bridge alone."""

    def __init__(
        self,
        robot_name: str,
        base_joint_states: str = "/wheel_ticks",
        use_move_base_action: bool = False,
    ) -> None:
        super().__init__(
            robot_name, "/mobile_base/cmd_vel", "/mobile_base/odom", use_move_base_action
        )
        self.base_joint_states = base_joint_states
        rospy.sleep(0.5)
        print("Initialized InterbotixCreate3Interface!\n")  # noqa: T201
