"""What is below `/io` of a Sawyer: devices with signals, which are set and asked for by name."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from typing import Any

import intera_dataflow
import rospy
from intera_core_msgs.msg import IOComponentCommand, IODeviceStatus

__all__ = ["Cuff", "Device", "Lights", "Navigator"]

_BUTTONS = {0: "OFF", 1: "CLICK", 2: "LONG_PRESS", 3: "DOUBLE_CLICK"}
_TIMEOUT_S = 5.0


class Device:
    """Knows the signals of a device, sets them, and calls functions when they change."""

    def __init__(self, node: str, name: str) -> None:
        self._path = f"/io/{node}/{name}"
        self._signals: dict[str, Any] = {}
        self._taken: tuple[Any, ...] = ()
        self._changes: dict[str, tuple[str, Any]] = {}
        self._numbers = itertools.count()
        self._commands = rospy.Publisher(f"{self._path}/command", IOComponentCommand, queue_size=10)
        self._states = rospy.Subscriber(f"{self._path}/state", IODeviceStatus, self._on_state)
        intera_dataflow.wait_for(
            lambda: self._signals,
            timeout=_TIMEOUT_S,
            timeout_msg=f"Failed to get the state of {self._path}",
        )

    def _on_state(self, msg: Any) -> None:
        before = self._signals
        self._signals = {signal.name: json.loads(signal.data)[0] for signal in msg.signals}
        self._taken = tuple(msg.commands)
        for name, changed in tuple(self._changes.values()):
            value = self._signals.get(name)
            if name in before and before[name] != value:
                changed(value)

    def list_signal_names(self) -> list[str]:
        """Return the names of the signals."""
        return list(self._signals)

    def get_signal_value(self, signal_name: str) -> Any:
        """Return the value of a signal, `None` for one that is not there."""
        return self._signals.get(signal_name)

    def set_signal_value(
        self,
        signal_name: str,
        signal_value: Any,
        signal_type: str | None = None,
        timeout: float = 5.0,
    ) -> bool:
        """Set a signal, and wait until the device has it; return whether it has."""
        kind = signal_type or ("bool" if isinstance(signal_value, bool) else "float")
        signal = {"format": {"type": kind}, "data": [signal_value]}
        arguments = json.dumps({"signals": {signal_name: signal}})
        command = IOComponentCommand(rospy.Time.now(), "set", arguments)
        is_taken: bool = intera_dataflow.wait_for(
            lambda: command.time in self._taken,
            timeout=timeout,
            raise_on_error=False,
            rate=10,
            body=lambda: self._commands.publish(command),
        )
        return is_taken

    def register_callback(
        self, callback_function: Callable[[Any], Any], signal_name: str, poll_rate: float = 10
    ) -> str:
        """Call a function with the new value whenever a signal changes; return its key."""
        del poll_rate
        key = f"{signal_name}_{next(self._numbers)}"
        self._changes[key] = signal_name, callback_function
        return key

    def deregister_callback(self, callback_id: str) -> bool:
        """Call a function no more; return whether it was called until now."""
        return self._changes.pop(callback_id, None) is not None


class Lights(Device):
    """Switches the lights of head and hand."""

    def __init__(self) -> None:
        super().__init__("robot", "robot")

    def list_all_lights(self) -> list[str]:
        """Return the names of the lights."""
        return [name for name in self.list_signal_names() if "light" in name]

    def set_light_state(self, name: str, on: bool = True) -> bool:
        """Switch a light; return whether it is switched."""
        return self.set_signal_value(name, bool(on))

    def get_light_state(self, name: str) -> Any:
        """Return whether a light is on."""
        return self.get_signal_value(name)


class Cuff(Device):
    """Reports the cuff around the wrist and its buttons."""

    def __init__(self, limb: str = "right") -> None:
        super().__init__("robot", "cuff")
        self._limb = limb

    def lower_button(self) -> bool:
        """Return whether the lower button is pressed."""
        return bool(self.get_signal_value(f"{self._limb}_button_lower"))

    def upper_button(self) -> bool:
        """Return whether the upper button is pressed."""
        return bool(self.get_signal_value(f"{self._limb}_button_upper"))

    def cuff_button(self) -> bool:
        """Return whether the cuff is squeezed."""
        return bool(self.get_signal_value(f"{self._limb}_cuff"))


class Navigator(Device):
    """Reports the buttons and wheels of head and arm."""

    def __init__(self) -> None:
        super().__init__("robot", "navigator")

    def list_all_items(self) -> list[str]:
        """Return the names of buttons and wheels."""
        return self.list_signal_names()

    def get_wheel_state(self, wheel_name: str) -> int:
        """Return where a wheel stands."""
        return int(self.get_signal_value(wheel_name) or 0)

    def get_button_state(self, button_name: str) -> int:
        """Return how a button is pressed, 0 for not at all."""
        return int(self.get_signal_value(button_name) or 0)

    def button_string_lookup(self, button_value: int) -> str:
        """Return the name of a button's state."""
        return _BUTTONS.get(int(button_value), "UNDEFINED")
