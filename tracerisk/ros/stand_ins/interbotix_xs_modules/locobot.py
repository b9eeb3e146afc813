"""A LoCoBot: arm, gripper and camera on a base (ROS 1)."""

from __future__ import annotations

import sys
from typing import Any

import rospy
from interbotix_perception_modules.armtag import InterbotixArmTagInterface
from interbotix_perception_modules.pointcloud import InterbotixPointCloudInterface

from .arm import InterbotixArmXSInterface
from .core import InterbotixRobotXSCore
from .create3 import InterbotixCreate3Interface
from .gripper import InterbotixGripperXSInterface
from .kobuki import InterbotixKobukiInterface
from .turret import InterbotixTurretXSInterface

__all__ = ["InterbotixLocobotXS"]

_PARTS = {"base": "use_base", "pcl": "use_perception", "armtag": "use_armtag"}


class InterbotixLocobotXS:
    """A LoCoBot by its model: `dxl` the driver, `camera`, and `arm` and `gripper` if it has them.

    `base`, `pcl` and `armtag` are there where the launch file turned them on. Its parameters say
    so; where they are not known, each part is made once it is used.
    """

    def __init__(
        self,
        robot_model: str,
        arm_model: str | None = None,
        arm_group_name: str = "arm",
        gripper_name: str = "gripper",
        turret_group_name: str = "camera",
        robot_name: str = "locobot",
        init_node: bool = True,
        dxl_joint_states: str = "dynamixel/joint_states",
        base_joint_states: str = "mobile_base/joint_states",
        use_move_base_action: bool = False,
    ) -> None:
        self.dxl = InterbotixRobotXSCore(robot_model, robot_name, init_node, dxl_joint_states)
        self.camera = InterbotixTurretXSInterface(self.dxl, turret_group_name)
        self._robot_name = robot_name
        self._of_base = base_joint_states, use_move_base_action
        self._has_arm = arm_model is not None
        if arm_model is not None:
            self.arm = InterbotixArmXSInterface(self.dxl, arm_model, arm_group_name)
            self.gripper = InterbotixGripperXSInterface(self.dxl, gripper_name)
        for name, parameter in _PARTS.items():
            if rospy.get_param(f"/{robot_name}/{parameter}", False):
                getattr(self, name)

    def __getattr__(self, name: str) -> Any:
        parameter = _PARTS.get(name)
        is_off = parameter is None or (name == "armtag" and not self._has_arm)
        if is_off or not rospy.get_param(f"/{self._robot_name}/{parameter}", True):
            raise AttributeError(f"'InterbotixLocobotXS' object has no attribute '{name}'")
        part = getattr(self, f"_make_{name}")()
        setattr(self, name, part)
        return part

    def _make_base(self) -> Any:
        # A program that uses messages of the Kobuki is for a LoCoBot that has one.
        usual = "kobuki" if "kobuki_msgs" in sys.modules else "create3"
        kind = rospy.get_param(f"/{self._robot_name}/base_type", usual)
        wheels, uses_action = self._of_base
        if kind == "kobuki":
            return InterbotixKobukiInterface(self._robot_name, wheels, uses_action)
        if kind == "create3":
            ticks = "/mobile_base/wheel_ticks"
            return InterbotixCreate3Interface(self._robot_name, ticks, uses_action)
        raise ValueError(
            f"Parameter '/{self._robot_name}/base_type' is an invalid value: was '{kind}' but must "
            "be 'kobuki' or 'create3'."
        )

    def _make_pcl(self) -> Any:
        return InterbotixPointCloudInterface(f"{self._robot_name}/pc_filter", init_node=False)

    def _make_armtag(self) -> Any:
        name = self._robot_name
        return InterbotixArmTagInterface(f"{name}/armtag", f"{name}/apriltag", init_node=False)
