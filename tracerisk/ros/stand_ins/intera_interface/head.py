"""The head of a Sawyer, and its display."""

from __future__ import annotations

from typing import Any

import intera_dataflow
import rospy
from intera_core_msgs.msg import HeadPanCommand, HeadState

from . import settings

__all__ = ["Head", "HeadDisplay"]


class Head:
    """Pans the head and reports where it looks."""

    def __init__(self) -> None:
        self._state: dict[str, Any] = {}
        self._pub_pan = rospy.Publisher(
            "/robot/head/command_head_pan", HeadPanCommand, queue_size=10
        )
        topic = "/robot/head/head_state"
        self._sub_state = rospy.Subscriber(topic, HeadState, self._on_head_state)
        intera_dataflow.wait_for(
            lambda: self._state,
            timeout=5.0,
            timeout_msg=f"Failed to get current head state from {topic}",
        )

    def _on_head_state(self, msg: Any) -> None:
        self._state = {"pan": msg.pan, "panning": msg.isTurning, "blocked": msg.isBlocked}

    def pan(self) -> float:
        """Return the angle of the head [rad]."""
        return float(self._state["pan"])

    def panning(self) -> bool:
        """Return whether the head turns."""
        return bool(self._state["panning"])

    def blocked(self) -> bool:
        """Return whether something holds the head."""
        return bool(self._state["blocked"])

    def set_pan(
        self,
        angle: float,
        speed: float = 1.0,
        timeout: float = 10.0,
        active_cancellation: bool = False,
    ) -> None:
        """Turn the head to an angle [rad] at a fraction of its speed, and wait unless 0.

        Raises:
            OSError: it is not there in time.
        """
        mode = HeadPanCommand.SET_ACTIVE_MODE
        if active_cancellation:
            mode = HeadPanCommand.SET_ACTIVE_CANCELLATION_MODE
        message = HeadPanCommand(angle, speed, mode)
        self._pub_pan.publish(message)
        if timeout != 0:
            intera_dataflow.wait_for(
                lambda: abs(self.pan() - angle) <= settings.HEAD_PAN_ANGLE_TOLERANCE,
                timeout=timeout,
                rate=100,
                timeout_msg=f"Failed to move head to pan command {angle:f}",
                body=lambda: self._pub_pan.publish(message),
            )


class HeadDisplay:
    """Shows pictures on the head: nothing moves by it, and nobody looks at them."""

    def display_image(
        self, image_path: Any, display_in_loop: bool = False, display_rate: float = 1.0
    ) -> None:
        """Take a picture, or several, and show none."""
        del image_path, display_in_loop, display_rate
