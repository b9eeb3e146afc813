"""The Kobuki base of a LoCoBot (ROS 2)."""

from __future__ import annotations

from typing import Any

from .mobile_base import InterbotixMobileBaseInterface

__all__ = ["InterbotixKobukiInterface"]


class InterbotixKobukiInterface(InterbotixMobileBaseInterface):
    """Drives the base."""

    def __init__(
        self,
        core: Any,
        robot_name: str,
        topic_base_joint_states: str = "mobile_base/joint_states",
        topic_cmd_vel: str = "mobile_base/commands/velocity",
        nav_timeout_sec: float = 300.0,
        use_nav: bool = False,
    ) -> None:
        super().__init__(
            core, robot_name, topic_base_joint_states, topic_cmd_vel, nav_timeout_sec, use_nav
        )
        core.get_node().loginfo("Initialized InterbotixKobukiInterface!")
