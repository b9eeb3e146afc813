"""What the parameters of a Sawyer say of its parts."""

from __future__ import annotations

from typing import Any

import rospy

__all__ = ["CAMERAS", "RobotParams"]

CAMERAS = ("head_camera", "right_hand_camera")


class RobotParams:
    """Asks the parameters which robot it is, and what it has."""

    def __init__(self) -> None:
        self._sdk_networked = True

    def get_camera_names(self) -> list[str]:
        """Return the cameras."""
        return list(CAMERAS)

    def get_camera_details(self) -> dict[str, Any]:
        """Return the details of each camera."""
        return {name: {} for name in self.get_camera_names()}

    def get_robot_assemblies(self) -> list[str]:
        """Return the parts of the robot: limbs, head and torso."""
        return list(rospy.get_param("/robot_config/assembly_names", []))

    def get_limb_names(self) -> list[str]:
        """Return the limbs."""
        return [name for name in self.get_robot_assemblies() if name not in ("head", "torso")]

    def get_joint_names(self, limb_name: str) -> list[str]:
        """Return the joints of a limb, from the base to the wrist."""
        return list(rospy.get_param(f"/robot_config/{limb_name}_config/joint_names", []))

    def get_robot_name(self) -> str | None:
        """Return the class of the robot: `sawyer`."""
        name: str | None = rospy.get_param("/manifest/robot_class", None)
        return name

    def log_message(self, msg: str, level: str = "INFO") -> None:
        """Log a text at a level."""
        log = {"WARN": rospy.logwarn, "ERROR": rospy.logerr}.get(level, rospy.loginfo)
        log(msg)
