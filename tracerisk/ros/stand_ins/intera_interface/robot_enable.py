"""Enables and stops the robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import intera_dataflow
import rospy
from intera_core_msgs.msg import RobotAssemblyState
from std_msgs.msg import Bool, Empty

__all__ = ["RobotEnable"]


class RobotEnable:
    """Asks for the robot's state and changes it."""

    def __init__(self, versioned: bool = False) -> None:
        del versioned
        self._state: Any = None
        topic = "robot/state"
        self._state_sub = rospy.Subscriber(topic, RobotAssemblyState, self._state_callback)
        intera_dataflow.wait_for(
            lambda: self._state is not None,
            timeout=5.0,
            timeout_msg=f"Failed to get robot state on {topic}",
        )

    def _state_callback(self, msg: Any) -> None:
        self._state = msg

    def state(self) -> Any:
        """Return the last RobotAssemblyState."""
        return self._state

    def enable(self) -> bool:
        """Enable all joints; a stopped robot is reset first. Return whether they are."""
        if self._state.stopped:
            rospy.loginfo("Robot Stopped: Attempting Reset...")
            self.reset()
        return self._toggle(status=True)

    def disable(self) -> bool:
        """Disable all joints; return whether they are."""
        return self._toggle(status=False)

    def _toggle(self, *, status: bool) -> bool:
        is_done = self._ask(
            "robot/set_super_enable",
            Bool,
            lambda: self._state.enabled == status,
            f"Failed to {'en' if status else 'dis'}able robot",
            (status,),
        )
        rospy.loginfo("Robot %s", "Enabled" if status else "Disabled")
        return is_done

    def reset(self) -> bool:
        """Clear the stopped state, which leaves the robot disabled; return whether it is."""
        return self._ask(
            "robot/set_super_reset",
            Empty,
            lambda: not (self._state.stopped or self._state.error),
            "Failed to reset robot",
        )

    def stop(self) -> bool:
        """Stop the robot, as its emergency stop does; return whether it is disabled."""
        return self._ask(
            "robot/set_super_stop",
            Empty,
            lambda: not self._state.enabled,
            "Failed to stop the robot",
        )

    def _ask(
        self,
        topic: str,
        kind: Any,
        test: Callable[[], bool],
        timeout_msg: str,
        given: tuple[Any, ...] = (),
    ) -> bool:
        publisher = rospy.Publisher(topic, kind, queue_size=10)
        is_done: bool = intera_dataflow.wait_for(
            test, timeout=5.0, timeout_msg=timeout_msg, body=lambda: publisher.publish(*given)
        )
        return is_done

    def version_check(self) -> bool:
        """Return whether the robot's software fits the SDK; the twin's does."""
        return True
