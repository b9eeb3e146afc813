"""The robot and its parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rospy

from ._arm import Arm
from ._configs import config_of
from ._parts import Base, Camera, Gripper, TopicGripper

__all__ = ["Arm", "Base", "Camera", "Gripper", "Robot"]

_KNOWN = ("locobot", "sawyer", "ur5")


class Robot:
    """A robot by its name: `arm`, `gripper`, and of a LoCoBot `base` and `camera`.

    Raises:
        ValueError: the library does not know the name.
    """

    def __init__(
        self,
        robot_name: str,
        use_arm: bool = True,
        use_base: bool = True,
        use_camera: bool = True,
        use_gripper: bool = True,
        arm_config: Mapping[str, Any] | None = None,
        base_config: Mapping[str, Any] | None = None,
        camera_config: Mapping[str, Any] | None = None,
        gripper_config: Mapping[str, Any] | None = None,
        common_config: Mapping[str, Any] | None = None,
    ) -> None:
        del base_config, camera_config, common_config
        kind = next((name for name in _KNOWN if name in robot_name), None)
        if kind is None:
            raise ValueError(
                "Invalid robot name provided, only the following are currently available: "
                f"{list(_KNOWN)}"
            )
        try:
            rospy.init_node("pyrobot", anonymous=True)
        except rospy.exceptions.ROSException:
            rospy.logwarn("ROS node [pyrobot] has already been initialized")
        is_locobot = kind == "locobot"
        self.configs = config_of(kind)
        if use_arm:
            self.arm = Arm(self.configs, **(arm_config or {}))
        if is_locobot and use_base:
            self.base = Base(self.configs)
        if is_locobot and use_camera:
            self.camera = Camera(self.configs)
        if use_arm and use_gripper and kind != "ur5":
            gripper = TopicGripper if is_locobot else Gripper
            self.gripper = gripper(self.configs, **(gripper_config or {}))
        rospy.sleep(2)
