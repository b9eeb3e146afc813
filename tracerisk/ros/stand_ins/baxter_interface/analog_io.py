"""An analog input or output of a Baxter: a range sensor, the fan of the torso."""

from __future__ import annotations

from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import AnalogIOState, AnalogOutputCommand

__all__ = ["AnalogIO"]


class AnalogIO:
    """Reads a component, and sets it where it is an output."""

    def __init__(self, component_id: str) -> None:
        self._id = component_id
        self._state: float | None = None
        self._is_output = False
        topic = f"/robot/analog_io/{component_id}/state"
        self._sub_state = rospy.Subscriber(topic, AnalogIOState, self._on_io_state)
        baxter_dataflow.wait_for(
            lambda: self._state is not None,
            timeout=2.0,
            timeout_msg=f"Failed to get current analog_io state from {topic}",
        )
        self._pub_output: Any = None
        if self._is_output:
            self._pub_output = rospy.Publisher(
                "/robot/analog_io/command", AnalogOutputCommand, queue_size=10
            )

    def _on_io_state(self, msg: Any) -> None:
        self._state, self._is_output = msg.value, not msg.isInputOnly

    def state(self) -> float | None:
        """Return the value of the component."""
        return self._state

    def is_output(self) -> bool:
        """Return whether the component can be set."""
        return self._is_output

    def set_output(self, value: int, timeout: float = 2.0) -> None:
        """Set an output, and wait until it is so unless `timeout` [s] is 0.

        Raises:
            OSError: the component is an input, or is not so in time.
        """
        if not self._is_output:
            raise OSError(f"Component is not an output [{self._id}]")
        message = AnalogOutputCommand(name=self._id, value=value)
        self._pub_output.publish(message)
        if timeout:
            baxter_dataflow.wait_for(
                lambda: self._state is not None and abs(self._state - value) <= 1.0,
                timeout=timeout,
                rate=100,
                timeout_msg=f"Failed to command analog io to: {value:d}",
                body=lambda: self._pub_output.publish(message),
            )
