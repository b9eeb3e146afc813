"""The Kobuki base of a LoCoBot (ROS 1)."""

from __future__ import annotations

from typing import Any

import rospy
from kobuki_msgs.msg import Sound
from sensor_msgs.msg import JointState
from std_msgs.msg import Empty

from ._base import BaseInterface

__all__ = ["InterbotixKobukiInterface"]


class InterbotixKobukiInterface(BaseInterface):
    """Drives the base, and plays its sounds."""

    def __init__(
        self, robot_name: str, base_joint_states: str, use_move_base_action: bool = False
    ) -> None:
        space = f"/{robot_name}/mobile_base"
        super().__init__(
            robot_name, f"{space}/commands/velocity", f"{space}/odom", use_move_base_action
        )
        self.wheel_states: Any = None
        reset = f"{space}/commands/reset_odometry"
        self.pub_base_reset = rospy.Publisher(reset, Empty, queue_size=1)
        self.pub_base_sound = rospy.Publisher(f"{space}/commands/sound", Sound, queue_size=1)
        self.sub_wheel_states = rospy.Subscriber(
            f"/{robot_name}/{base_joint_states}", JointState, self.wheel_states_cb
        )
        rospy.sleep(0.5)
        print("Initialized InterbotixKobukiInterface!\n")  # noqa: T201

    def wheel_states_cb(self, msg: Any) -> None:
        """Keep the last states of the wheels."""
        self.wheel_states = msg

    def get_wheel_states(self) -> list[float]:
        """Return the angles of the two wheels [rad]."""
        return list(self.wheel_states.position)

    def command_sound(self, sound: int) -> None:
        """Play a sound."""
        self.pub_base_sound.publish(sound)

    def reset_odom(self) -> None:
        """Set the odometry to zero."""
        self.pub_base_reset.publish(Empty())
        self.pub_base_sound.publish(Sound(value=Sound.CLEANINGEND))
