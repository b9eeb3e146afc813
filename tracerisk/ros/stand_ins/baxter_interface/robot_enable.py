"""Enables and stops the robot."""

from __future__ import annotations

from threading import Lock
from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import AssemblyState
from std_msgs.msg import Bool, Empty

__all__ = ["RobotEnable"]


class RobotEnable:
    """Asks for the robot's state and changes it."""

    param_lock = Lock()

    def __init__(self, versioned: bool = False) -> None:
        self._state: Any = None
        topic = "robot/state"
        self._state_sub = rospy.Subscriber(topic, AssemblyState, self._state_callback)
        baxter_dataflow.wait_for(
            lambda: self._state is not None,
            timeout=2.0,
            timeout_msg=f"Failed to get robot state on {topic}",
        )

    def _state_callback(self, msg: Any) -> None:
        self._state = msg

    def state(self) -> Any:
        """Return the last AssemblyState."""
        return self._state

    def enable(self) -> None:
        """Enable all joints; a stopped robot is reset first.

        Raises:
            OSError: it is not enabled within 2 s.
        """
        if self._state.stopped:
            rospy.loginfo("Robot Stopped: Attempting Reset...")
            self.reset()
        self._toggle(True)

    def disable(self) -> None:
        """Disable all joints.

        Raises:
            OSError: it is not disabled within 5 s.
        """
        self._toggle(False)

    def _toggle(self, status: bool) -> None:
        publisher = rospy.Publisher("robot/set_super_enable", Bool, queue_size=10)
        baxter_dataflow.wait_for(
            lambda: self._state.enabled == status,
            timeout=2.0 if status else 5.0,
            timeout_msg=f"Failed to {'en' if status else 'dis'}able robot",
            body=lambda: publisher.publish(status),
        )
        rospy.loginfo("Robot %s", "Enabled" if status else "Disabled")

    def reset(self) -> None:
        """Clear the stopped state, which leaves the robot disabled.

        Raises:
            OSError: it is not cleared within 3 s.
        """
        publisher = rospy.Publisher("robot/set_super_reset", Empty, queue_size=10)
        rospy.loginfo("Resetting robot...")
        baxter_dataflow.wait_for(
            lambda: not (self._state.enabled or self._state.stopped or self._state.error),
            timeout=3.0,
            timeout_msg="Failed to reset robot.",
            body=publisher.publish,
        )

    def stop(self) -> None:
        """Stop the robot, as its emergency stop does.

        Raises:
            OSError: it is not stopped within 3 s.
        """
        publisher = rospy.Publisher("robot/set_super_stop", Empty, queue_size=10)
        baxter_dataflow.wait_for(
            lambda: self._state.stopped,
            timeout=3.0,
            timeout_msg="Failed to stop the robot",
            body=publisher.publish,
        )

    def version_check(self) -> bool:
        """Return whether the robot's software fits the SDK; the twin's does."""
        return True
