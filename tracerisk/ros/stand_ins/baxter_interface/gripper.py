"""An electric gripper of a Baxter."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from typing import Any

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import EndEffectorCommand, EndEffectorProperties, EndEffectorState

__all__ = ["Gripper"]

_TYPES = {
    EndEffectorProperties.SUCTION_CUP_GRIPPER: "suction",
    EndEffectorProperties.ELECTRIC_GRIPPER: "electric",
    EndEffectorProperties.PASSIVE_GRIPPER: "custom",
}
_PARAMETERS = {"velocity": 50.0, "moving_force": 40.0, "holding_force": 30.0, "dead_zone": 5.0}


class Gripper:
    """Commands a gripper by its side, and reports its state; the twin's are electric."""

    def __init__(self, gripper: str, versioned: bool = False) -> None:
        self.name = gripper + "_gripper"
        self._cmd_sender = rospy.get_name() + "_%s"
        self._cmd_sequence = 0
        self._state: Any = None
        self._prop = EndEffectorProperties()
        self._has_prop = False
        self._parameters: dict[str, float] = {}
        self.on_type_changed = baxter_dataflow.Signal()
        self.on_gripping_changed = baxter_dataflow.Signal()
        self.on_moving_changed = baxter_dataflow.Signal()
        space = f"robot/end_effector/{self.name}/"
        self._cmd_pub = rospy.Publisher(space + "command", EndEffectorCommand, queue_size=10)
        rospy.Subscriber(space + "state", EndEffectorState, self._on_gripper_state)
        rospy.Subscriber(space + "properties", EndEffectorProperties, self._on_gripper_prop)
        for topic, test in (
            ("state", lambda: self._state is not None),
            ("properties", lambda: self._has_prop),
        ):
            baxter_dataflow.wait_for(
                test, timeout=5.0, timeout_msg=f"Failed to get {topic} from {space}{topic}"
            )
        # The robot sends state and properties seldom: when both are here, commands are connected.
        baxter_dataflow.wait_for(
            lambda: self._cmd_pub.get_num_connections() > 0, timeout=5.0, raise_on_error=False
        )
        self.set_parameters(defaults=True)

    def _on_gripper_state(self, state: Any) -> None:
        before, self._state = self._state, deepcopy(state)
        if before is not None and before.gripping != state.gripping:
            self.on_gripping_changed(bool(state.gripping))
        if before is not None and before.moving != state.moving:
            self.on_moving_changed(bool(state.moving))

    def _on_gripper_prop(self, properties: Any) -> None:
        self._prop, self._has_prop = deepcopy(properties), True

    def _warn(self, command: str) -> None:
        rospy.logwarn(f"{self.name} {self.type()} - not capable of '{command}' command")

    def version_check(self) -> bool:
        """Return whether the firmware fits the SDK; the twin's does."""
        return True

    def command(
        self,
        cmd: str,
        block: bool = False,
        test: Callable[[], Any] = lambda: True,
        timeout: float = 0.0,
        args: Mapping[str, float] | None = None,
    ) -> bool:
        """Send a command; with `block`, wait until it is taken and the test holds."""
        self._cmd_sequence = self._cmd_sequence % 0x7FFFFFFF + 1
        message = EndEffectorCommand()
        message.id = self.hardware_id()
        message.command, message.sender = cmd, self._cmd_sender % cmd
        message.sequence = self._cmd_sequence
        message.args = "" if args is None else json.dumps(dict(args))
        self._cmd_pub.publish(message)
        if not block:
            return True
        end = rospy.get_time() + timeout
        sequence = message.sequence

        def again() -> None:
            self._cmd_pub.publish(message)

        baxter_dataflow.wait_for(
            lambda: (
                self._state.command_sender == message.sender
                and self._state.command_sequence in (sequence, 0)
            ),
            timeout=timeout,
            raise_on_error=False,
            body=again,
        )
        left = max(0.5, end - rospy.get_time())
        return bool(baxter_dataflow.wait_for(test, timeout=left, raise_on_error=False, body=again))

    # Parameters

    def valid_parameters(self) -> dict[str, float]:
        """Return the parameters of an electric gripper with their defaults [%]."""
        return dict(_PARAMETERS) if self.type() == "electric" else {}

    def valid_parameters_text(self) -> str:
        """Return the parameters as a text."""
        names = ", ".join(self.valid_parameters())
        return f"Valid gripper parameters for the {self.type()} gripper are {names} (0-100)."

    def set_parameters(
        self, parameters: Mapping[str, float] | None = None, defaults: bool = False
    ) -> None:
        """Set parameters [%]; unknown ones are warned of."""
        valid = self.valid_parameters()
        if defaults:
            self._parameters = valid
        for name, value in (parameters or {}).items():
            if name in valid:
                self._parameters[name] = value
            else:
                rospy.logwarn(f"Invalid parameter: {name} provided. {self.valid_parameters_text()}")
        self.command(EndEffectorCommand.CMD_CONFIGURE, args=self._parameters)

    def parameters(self) -> dict[str, float]:
        """Return the parameters [%]."""
        return deepcopy(self._parameters)

    def set_velocity(self, velocity: float) -> None:
        """Set the speed of moves [%]."""
        self.set_parameters({"velocity": _clipped(velocity)})

    def set_moving_force(self, force: float) -> None:
        """Set the force at which a move ends [%]."""
        self.set_parameters({"moving_force": _clipped(force)})

    def set_holding_force(self, force: float) -> None:
        """Set the force that holds [%]."""
        self.set_parameters({"holding_force": _clipped(force)})

    def set_dead_band(self, dead_band: float) -> None:
        """Set how near to its goal a move has succeeded [%]."""
        self.set_parameters({"dead_zone": _clipped(dead_band)})

    # Commands

    def reset(self, block: bool = True, timeout: float = 2.0) -> Any:
        """Clear errors."""
        return self._electric(
            EndEffectorCommand.CMD_RESET, block, lambda: self._state.ready == 1, timeout
        )

    def reboot(self, timeout: float = 5.0, delay_check: float = 0.1) -> Any:
        """Start anew; the gripper is to be calibrated again."""
        done = self._electric(
            EndEffectorCommand.CMD_REBOOT, True, lambda: not self.calibrated(), timeout
        )
        rospy.sleep(delay_check)
        self.set_parameters(defaults=True)
        return done

    def clear_calibration(self, block: bool = True, timeout: float = 2.0) -> Any:
        """Forget the calibration."""
        command = EndEffectorCommand.CMD_CLEAR_CALIBRATION
        return self._electric(command, block, lambda: not self.calibrated(), timeout)

    def calibrate(self, block: bool = True, timeout: float = 5.0) -> Any:
        """Calibrate, which positions need; return whether it succeeded."""
        if self.type() == "electric" and self.calibrated():
            self.clear_calibration()
        command = EndEffectorCommand.CMD_CALIBRATE
        done = self._electric(command, block, self.calibrated, timeout)
        self.set_parameters(defaults=True)
        return done

    def stop(self, block: bool = True, timeout: float = 5.0) -> Any:
        """Stop the fingers where they are."""
        command = EndEffectorCommand.CMD_STOP
        return self._electric(command, block, lambda: not self.moving(), timeout)

    def command_position(self, position: float, block: bool = False, timeout: float = 5.0) -> Any:
        """Move the fingers: 0 closed, 100 open [%]."""
        if self.type() == "electric" and not self.calibrated():
            rospy.logwarn(f"Unable to command {self.name} position until calibrated")
            return False
        goal = _clipped(position)
        return self._electric(
            EndEffectorCommand.CMD_GO,
            block,
            lambda: abs(self.position() - goal) < self._parameters["dead_zone"] or self.gripping(),
            timeout,
            {"position": goal},
        )

    def open(self, block: bool = False, timeout: float = 5.0) -> Any:
        """Open the gripper."""
        return self.command_position(100.0, block, timeout)

    def close(self, block: bool = False, timeout: float = 5.0) -> Any:
        """Close the gripper."""
        return self.command_position(0.0, block, timeout)

    def _electric(
        self,
        command: str,
        block: bool,
        test: Callable[[], Any],
        timeout: float,
        args: Mapping[str, float] | None = None,
    ) -> Any:
        if self.type() != "electric":
            return self._warn(command)
        return self.command(command, block, test, timeout, args)

    # State

    def calibrated(self) -> bool:
        """Return whether the gripper is calibrated."""
        return bool(self._state.calibrated == 1)

    def ready(self) -> bool:
        """Return whether the gripper takes commands."""
        return bool(self._state.ready == 1)

    def moving(self) -> bool:
        """Return whether the fingers move."""
        return bool(self._state.moving == 1)

    def gripping(self) -> bool:
        """Return whether the fingers hold something."""
        return bool(self._state.gripping == 1)

    def missed(self) -> bool:
        """Return whether the fingers closed on nothing."""
        return bool(self._state.missed == 1)

    def error(self) -> bool:
        """Return whether the gripper has an error."""
        return bool(self._state.error == 1)

    def position(self) -> float:
        """Return how far the gripper is open [%]."""
        return float(self._state.position)

    def force(self) -> float:
        """Return the force of the fingers [%]."""
        return float(self._state.force)

    def has_force(self) -> bool:
        """Return whether force can be set."""
        return bool(self._prop.controls_force)

    def has_position(self) -> bool:
        """Return whether positions can be set."""
        return bool(self._prop.controls_position)

    def type(self) -> str | None:
        """Return `electric`, `suction` or `custom`, None for no gripper."""
        return _TYPES.get(self._prop.ui_type)

    def hardware_id(self) -> int:
        """Return the number of the gripper's kind."""
        return int(self._state.id)

    def hardware_name(self) -> str:
        """Return the maker and the product."""
        return f"{self._prop.manufacturer} {self._prop.product}"

    def firmware_build_date(self) -> str:
        """Return when the firmware was built."""
        return str(self._prop.firmware_date)

    def firmware_version(self) -> str:
        """Return the version of the firmware."""
        return str(self._prop.firmware_rev)


def _clipped(value: float) -> float:
    return max(min(value, 100.0), 0.0)
