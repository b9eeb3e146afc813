"""A LoCoBot: arm, gripper and camera on a base (ROS 2)."""

from __future__ import annotations

from enum import Enum
from typing import Any

import rclpy
from interbotix_common_modules.common_robot.robot import interbotix_is_up, robot_startup
from rclpy.logging import LoggingSeverity

from .arm import InterbotixArmXSInterface
from .core import InterbotixRobotXSCore
from .create3 import InterbotixCreate3Interface
from .gripper import InterbotixGripperXSInterface
from .kobuki import InterbotixKobukiInterface
from .turret import InterbotixTurretXSInterface

__all__ = ["BaseType", "InterbotixLocobotXS"]


class BaseType(Enum):
    """The bases that there are."""

    KOBUKI = 0
    CREATE3 = 1


class InterbotixLocobotXS:
    """A LoCoBot by its model: `core` the driver, `camera`, and `arm` and `gripper` if it has them.

    `base`, `pcl` and `armtag` are there where they are asked for.
    """

    def __init__(
        self,
        robot_model: str,
        arm_model: str | None = None,
        use_base: bool = False,
        use_perception: bool = False,
        use_armtag: bool = False,
        base_type: BaseType = BaseType.CREATE3,
        arm_group_name: str = "arm",
        gripper_name: str = "gripper",
        turret_group_name: str = "camera",
        robot_name: str = "locobot",
        topic_dxl_joint_states: str = "dynamixel/joint_states",
        topic_base_joint_states: str = "mobile_base/joint_states",
        use_nav: bool = False,
        logging_level: Any = LoggingSeverity.INFO,
        node_name: str = "robot_manipulation",
        start_on_init: bool = True,
        args: Any = None,
    ) -> None:
        self.core = InterbotixRobotXSCore(
            robot_model,
            robot_name,
            topic_dxl_joint_states,
            logging_level,
            node_name,
            args=args,
        )
        self.camera = InterbotixTurretXSInterface(self.core, turret_group_name)
        if use_base:
            self.base = _base_class(base_type)(
                self.core, robot_name, topic_base_joint_states, use_nav=use_nav
            )
        if use_perception:
            from interbotix_perception_modules.pointcloud import InterbotixPointCloudInterface

            self.pcl = InterbotixPointCloudInterface(
                f"{robot_name}/pc_filter", node_inf=self.core.get_node()
            )
        if arm_model is not None:
            self.arm = InterbotixArmXSInterface(self.core, arm_model, arm_group_name)
            self.gripper = InterbotixGripperXSInterface(self.core, gripper_name)
        if arm_model is not None and use_armtag:
            from interbotix_perception_modules.armtag import InterbotixArmTagInterface

            self.armtag = InterbotixArmTagInterface(
                f"{robot_name}/armtag", f"{robot_name}/apriltag", node_inf=self.core.get_node()
            )
        if start_on_init:
            self.start()

    def start(self) -> None:
        """Spin on a thread of its own."""
        if not interbotix_is_up():
            robot_startup(self.core.get_node())

    def get_node(self) -> Any:
        """Return the node of the driver's interface."""
        return self.core.get_node()

    def shutdown(self) -> None:
        """Destroy the node and shut ROS down."""
        self.core.get_node().destroy_node()
        rclpy.shutdown()


def _base_class(kind: BaseType) -> Any:
    if kind == BaseType.KOBUKI:
        return InterbotixKobukiInterface

    return InterbotixCreate3Interface
