"""The electric gripper of a Sawyer."""

from __future__ import annotations

from typing import Any

import intera_dataflow
import rospy
from intera_core_msgs.msg import IONodeConfiguration

from .devices import Device

__all__ = ["Gripper", "SimpleClickSmartGripper", "get_current_gripper_interface"]


class Gripper(Device):
    """Moves the fingers, and reports where they are.

    Raises:
        OSError: no gripper of that name is attached.
    """

    MAX_POSITION = 0.041667
    MIN_POSITION = 0.0
    MAX_FORCE = 10.0
    MIN_FORCE = 0.0
    MAX_VELOCITY = 3.0
    MIN_VELOCITY = 0.15

    def __init__(self, ee_name: str = "right_gripper", calibrate: bool = True) -> None:
        self.name = f"{ee_name}_gripper" if ee_name in ("left", "right") else ee_name
        self.devices: Any = None
        self._config = rospy.Subscriber(
            "/io/end_effector/config", IONodeConfiguration, self._on_config
        )
        intera_dataflow.wait_for(
            lambda: self.devices is not None,
            timeout=5.0,
            timeout_msg="Failed to get gripper. No gripper attached on the robot.",
        )
        super().__init__("end_effector", self.name)
        self.gripper_io = self
        if calibrate and not self.is_calibrated():
            self.calibrate()

    def _on_config(self, msg: Any) -> None:
        if any(device.name == self.name for device in msg.devices):
            self.devices = msg

    def reboot(self) -> bool:
        """Restart the gripper, which forgets its calibration."""
        return self.set_signal_value("reboot", True)

    def stop(self) -> bool:
        """Stop the fingers where they are."""
        return self.set_signal_value("go", False)

    def start(self) -> bool:
        """Go on with commands after a stop."""
        return self.set_signal_value("go", True)

    def open(self, position: float = MAX_POSITION) -> bool:
        """Open the fingers, to a position [m]."""
        return self.set_position(position)

    def close(self, position: float = MIN_POSITION) -> bool:
        """Close the fingers, to a position [m]."""
        return self.set_position(position)

    def calibrate(self) -> bool:
        """Find the ends of the fingers; return whether that was done."""
        self.set_signal_value("calibrate", True)
        return self.is_calibrated()

    def has_error(self) -> bool:
        """Return whether the gripper has an error."""
        return bool(self.get_signal_value("has_error"))

    def is_ready(self) -> bool:
        """Return whether it is calibrated, without an error and at rest."""
        return self.is_calibrated() and not self.has_error() and not self.is_moving()

    def is_moving(self) -> bool:
        """Return whether the fingers move."""
        return bool(self.get_signal_value("is_moving"))

    def is_gripping(self) -> bool:
        """Return whether something is between the fingers."""
        return bool(self.get_signal_value("is_gripping"))

    def is_calibrated(self) -> bool:
        """Return whether the ends of the fingers are known."""
        return bool(self.get_signal_value("is_calibrated"))

    def get_position(self) -> float:
        """Return how far the fingers are apart [m]."""
        return float(self.get_signal_value("position_response_m"))

    def set_position(self, position: float) -> bool:
        """Bring the fingers to a position [m]; return whether the gripper took it."""
        return self.set_signal_value("position_m", float(position))

    def set_velocity(self, speed: float) -> bool:
        """Set the speed of the fingers [m/s]; return whether the gripper took it."""
        return self.set_signal_value("speed_mps", float(speed))

    def get_cmd_velocity(self) -> float:
        """Return the speed that was set [m/s]."""
        return float(self.get_signal_value("speed_mps"))

    def get_force(self) -> float:
        """Return the force of the fingers [N]."""
        return float(self.get_signal_value("force_response_n"))

    def set_object_weight(self, object_weight: float) -> bool:
        """Set the mass of what is held [kg]; return whether the gripper took it."""
        return self.set_signal_value("right_gripper_tip_object_kg", float(object_weight))

    def get_object_weight(self) -> float:
        """Return the mass of what is held, as it was set [kg]."""
        return float(self.get_signal_value("right_gripper_tip_object_kg"))

    def set_dead_zone(self, dead_zone: float) -> bool:
        """Set how far from its goal a move may end [m]; return whether the gripper took it."""
        return self.set_signal_value("dead_zone_m", float(dead_zone))

    def get_dead_zone(self) -> float:
        """Return how far from its goal a move may end [m]."""
        return float(self.get_signal_value("dead_zone_m"))


class SimpleClickSmartGripper:
    """Is a gripper on a ClickSmart plate, which the twin's arm has not.

    Raises:
        OSError: always, as where none is attached.
    """

    def __init__(self, ee_device_id: str, initialize: bool = True) -> None:
        raise OSError(
            f"no ClickSmart gripper '{ee_device_id}' is attached; the twin has the electric one"
        )


def get_current_gripper_interface() -> Gripper:
    """Return the gripper that is attached."""
    return Gripper()
