"""The buttons, the wheel and the lights on a Baxter's arms and torso."""

from __future__ import annotations

from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import NavigatorState

from .digital_io import DigitalIO

__all__ = ["Navigator"]

_LOCATIONS = ("left", "right", "torso_left", "torso_right")


class Navigator:
    """Reads a navigator, and calls functions as it is used.

    Raises:
        AttributeError: there is none at that place.
    """

    def __init__(self, location: str) -> None:
        if location not in _LOCATIONS:
            raise AttributeError(f"Invalid Navigator name '{location}'")
        self._id = location
        self._state: Any = None
        self.button0_changed = baxter_dataflow.Signal()
        self.button1_changed = baxter_dataflow.Signal()
        self.button2_changed = baxter_dataflow.Signal()
        self.wheel_changed = baxter_dataflow.Signal()
        topic = f"/robot/navigators/{location}_navigator/state"
        self._state_sub = rospy.Subscriber(topic, NavigatorState, self._on_state)
        self._inner_led = DigitalIO(f"{location}_itb_light_inner")
        self._outer_led = DigitalIO(f"{location}_itb_light_outer")
        baxter_dataflow.wait_for(
            lambda: self._state is not None,
            timeout=5.0,
            timeout_msg=f"Navigator init failed to get current state from {topic}",
        )

    def _on_state(self, msg: Any) -> None:
        before, self._state = self._state, msg
        if before is None:
            return
        changed = (self.button0_changed, self.button1_changed, self.button2_changed)
        for old, new, signal in zip(before.buttons, msg.buttons, changed, strict=False):
            if old != new:
                signal(new)
        if before.wheel != msg.wheel:
            turned = msg.wheel - before.wheel
            # The count of the wheel runs from 0 to 255, and over.
            self.wheel_changed(
                turned - 256 if turned > 128 else turned + 256 if turned < -128 else turned
            )

    @property
    def wheel(self) -> int:
        """The count of the wheel, from 0 to 255."""
        return int(self._state.wheel)

    @property
    def button0(self) -> bool:
        """Whether the button on the wheel is pressed."""
        return bool(self._state.buttons[0])

    @property
    def button1(self) -> bool:
        """Whether the button above the wheel is pressed."""
        return bool(self._state.buttons[1])

    @property
    def button2(self) -> bool:
        """Whether the button below the wheel is pressed."""
        return bool(self._state.buttons[2])

    @property
    def inner_led(self) -> bool:
        """Whether the inner light is on."""
        return bool(self._state.lights[0])

    @inner_led.setter
    def inner_led(self, enable: bool) -> None:
        self._inner_led.set_output(enable)

    @property
    def outer_led(self) -> bool:
        """Whether the outer light is on."""
        return bool(self._state.lights[1])

    @outer_led.setter
    def outer_led(self, enable: bool) -> None:
        self._outer_led.set_output(enable)
