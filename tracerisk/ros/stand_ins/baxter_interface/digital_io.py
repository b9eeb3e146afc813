"""A digital input or output of a Baxter: a button, a cuff, a light, a suction cup's valve."""

from __future__ import annotations

from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import DigitalIOState, DigitalOutputCommand

__all__ = ["DigitalIO"]


class DigitalIO:
    """Reads a component, and sets it where it is an output."""

    def __init__(self, component_id: str) -> None:
        self._id = component_id
        self._is_output = False
        self._state: bool | None = None
        self.state_changed = baxter_dataflow.Signal()
        topic = f"/robot/digital_io/{component_id}/state"
        self._sub_state = rospy.Subscriber(topic, DigitalIOState, self._on_io_state)
        baxter_dataflow.wait_for(
            lambda: self._state is not None,
            timeout=2.0,
            timeout_msg=f"Failed to get current digital_io state from {topic}",
        )
        self._pub_output: Any = None
        if self._is_output:
            self._pub_output = rospy.Publisher(
                "/robot/digital_io/command", DigitalOutputCommand, queue_size=10
            )

    def _on_io_state(self, msg: Any) -> None:
        before, self._state = self._state, msg.state == DigitalIOState.PRESSED
        self._is_output = not msg.isInputOnly
        if before is not None and before != self._state:
            self.state_changed(self._state)

    @property
    def is_output(self) -> bool:
        """Whether the component can be set."""
        return self._is_output

    @property
    def state(self) -> bool | None:
        """Whether the component is on, or pressed."""
        return self._state

    @state.setter
    def state(self, value: bool) -> None:
        self.set_output(value)

    def set_output(self, value: bool, timeout: float = 2.0) -> None:
        """Set an output, and wait until it is so unless `timeout` [s] is 0.

        Raises:
            OSError: the component is an input, or is not so in time.
        """
        if not self._is_output:
            raise OSError(f"Component is not an output [{self._id}]")
        message = DigitalOutputCommand(name=self._id, value=bool(value))
        self._pub_output.publish(message)
        if timeout:
            baxter_dataflow.wait_for(
                lambda: self._state == bool(value),
                timeout=timeout,
                rate=100,
                timeout_msg=f"Failed to command digital io to: {value!r}",
                body=lambda: self._pub_output.publish(message),
            )
