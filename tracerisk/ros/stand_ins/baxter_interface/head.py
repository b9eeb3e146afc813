"""The head of a Baxter."""

from __future__ import annotations

from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import HeadPanCommand, HeadState

from . import settings

__all__ = ["Head"]


class Head:
    """Pans the head and reports where it looks."""

    def __init__(self) -> None:
        self._state: dict[str, Any] = {}
        self._pub_pan = rospy.Publisher(
            "/robot/head/command_head_pan", HeadPanCommand, queue_size=10
        )
        topic = "/robot/head/head_state"
        self._sub_state = rospy.Subscriber(topic, HeadState, self._on_head_state)
        baxter_dataflow.wait_for(
            lambda: self._state,
            timeout=5.0,
            timeout_msg=f"Failed to get current head state from {topic}",
        )

    def _on_head_state(self, msg: Any) -> None:
        self._state = {"pan": msg.pan, "panning": msg.isTurning, "nodding": msg.isNodding}

    def pan(self) -> float:
        """Return the angle of the head [rad]."""
        return float(self._state["pan"])

    def nodding(self) -> bool:
        """Return whether the head nods."""
        return bool(self._state["nodding"])

    def panning(self) -> bool:
        """Return whether the head turns."""
        return bool(self._state["panning"])

    def set_pan(
        self, angle: float, speed: float = 1.0, timeout: float = 10.0, scale_speed: bool = False
    ) -> None:
        """Turn the head to an angle [rad] at a fraction of its speed, and wait unless 0.

        Raises:
            OSError: it is not there in time.
        """
        ratio = speed / 100.0 if scale_speed else speed
        if not HeadPanCommand.MIN_SPEED_RATIO <= ratio <= HeadPanCommand.MAX_SPEED_RATIO:
            rospy.logerr(f"Commanded Speed, ({ratio}), outside of valid range [0.0, 1.0]")
        message = HeadPanCommand(angle, ratio, True)
        self._pub_pan.publish(message)
        if timeout != 0:
            baxter_dataflow.wait_for(
                lambda: abs(self.pan() - angle) <= settings.HEAD_PAN_ANGLE_TOLERANCE,
                timeout=timeout,
                rate=100,
                timeout_msg=f"Failed to move head to pan command {angle:f}",
                body=lambda: self._pub_pan.publish(message),
            )

    def command_nod(self, timeout: float = 5.0) -> None:
        """Nod.

        Raises:
            NotImplementedError: always; the twin's head only turns.
        """
        raise NotImplementedError("Head.command_nod: the twin's head turns, and does not nod")
