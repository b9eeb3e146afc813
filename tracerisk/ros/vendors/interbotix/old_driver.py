"""The driver of Interbotix arms before `xs_sdk`: `interbotix_sdk`, of the years up to 2020.

Its arm takes commands as one group, and its services name the servos by numbers. How the servos
were started is in no message: a profile of time is assumed where a `Profile_Velocity` above the
servos' limit of speed is set, which a profile of speeds refuses; the gripper's mode by the size of
its command, as a PWM is never below 1 and an opening never above. Source of the behaviour:
Interbotix/interbotix_ros_arms (`interbotix_sdk/src/arm_obj.cpp`, `launch/arm_run.launch`).
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.interbotix.dynamixel import SETTINGS
from tracerisk.ros.vendors.interbotix.servo_node import GRIPPER, ServoNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_PACKAGE = "interbotix_sdk"
_NUMBER = "std_msgs/Float64"
_EMPTY = "std_srvs/Empty"
_EVERYTHING, _ARM, _GRIPPER, _SINGLE = 1, 2, 3, 4
_LIMIT = 131  # Velocity_Limit of config/*.yaml
_START = {"Profile_Velocity": _LIMIT, "Profile_Acceleration": 15}
_LEAST_PWM = 1.0
_GAINS = {
    "Kp_pos": "Position_P_Gain",
    "Ki_pos": "Position_I_Gain",
    "Kd_pos": "Position_D_Gain",
    "K1": "Feedforward_1st_Gain",
    "K2": "Feedforward_2nd_Gain",
    "Kp_vel": "Velocity_P_Gain",
    "Ki_vel": "Velocity_I_Gain",
}


class InterbotixSdk(ServoNode):
    """Answers as the arm_node of the twin's arm."""

    node = "/arm_node"
    package = _PACKAGE

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        for name in self._arm:
            self._servos[name].profile_type = "velocity"
            self._servos[name].registers.update(_START)
        self._gripper_is_set = False
        for name, kind, handle in (
            ("get_robot_info", "RobotInfo", self._robot_info),
            ("set_operating_modes", "OperatingModes", self._set_modes),
            ("set_firmware_pid_gains", "FirmwareGains", self._set_gains),
            ("set_motor_register_values", "RegisterValues", self._set_registers),
            ("get_motor_register_values", "RegisterValues", self._get_registers),
        ):
            self._offer(name, f"{_PACKAGE}/{kind}", handle)
        self._offer("torque_joints_on", _EMPTY, lambda *_: self._torque(is_on=True))
        self._offer("torque_joints_off", _EMPTY, lambda *_: self._torque(is_on=False))
        self._takers = {
            f"{_PACKAGE}/JointCommands": self._take_arm,
            f"{_PACKAGE}/SingleCommand": self._take_single,
            _NUMBER: self._take_gripper,
        }
        self._graph.watch(self._on_change)

    def _takes(self, name: str, type_name: str) -> bool:
        if type_name == _NUMBER:
            is_of_it = self._gripper is not None and self._messages.is_used(_PACKAGE)
            return is_of_it and name.endswith(f"/{GRIPPER}/command")
        return super()._takes(name, type_name)

    # Services

    def _named(self, number: int, name: str) -> tuple[str, ...]:
        """Return the servos that a request is for.

        Raises:
            ServiceFailedError: none is meant.
        """
        gripper = (GRIPPER,) if self._gripper is not None else ()
        groups = {_EVERYTHING: (*self._arm, *gripper), _ARM: self._arm, _GRIPPER: gripper}
        if number == _SINGLE and name in self._servos:
            return (name,)
        if number in groups:
            return groups[number]
        text = f"'{name}' is no servo of robot '{self._twin.robot.name}'"
        if number != _SINGLE:
            text = f"cmd {number} means no servos; use 1 (all), 2 (arm), 3 (gripper) or 4 (one)"
        self._commands.report("service_refused", text)
        raise ServiceFailedError(text)

    def _robot_info(self, request: Any, answer: Any) -> None:
        robot = self._twin.robot
        joints = [robot.joint(name) for name in self._arm]
        asleep = self._asleep()
        names = list(self._servos)
        answer.joint_names = names
        answer.joint_ids = list(range(1, len(names) + 1))
        answer.lower_joint_limits = [joint.lower for joint in joints]
        answer.upper_joint_limits = [joint.upper for joint in joints]
        answer.velocity_limits = [joint.velocity_limit for joint in joints]
        if self._gripper is not None:
            finger = robot.joint(self._gripper.joints[0])
            answer.use_gripper = True
            answer.lower_gripper_limit = finger.lower
            answer.upper_gripper_limit = finger.upper
            # Its servo turns all the way round.
            answer.lower_joint_limits.append(-math.pi)
            answer.upper_joint_limits.append(math.pi)
            answer.velocity_limits.append(math.pi)
        answer.home_pos = [0.0] * len(self._arm)
        answer.sleep_pos = [asleep.get(name, 0.0) for name in self._arm]
        answer.num_joints = len(self._arm)
        answer.num_single_joints = len(names)

    def _set_modes(self, request: Any, answer: Any) -> None:
        for name in self._named(request.cmd, request.joint_name):
            servo = self._servos[name]
            servo.mode = request.mode
            self._gripper_is_set |= name == GRIPPER
            if request.use_custom_profiles:
                self._set(name, "Profile_Velocity", request.profile_velocity)
                self._set(name, "Profile_Acceleration", request.profile_acceleration)

    def _set_gains(self, request: Any, answer: Any) -> None:
        names = [*self._servos]
        if request.joint_id:
            names = names[request.joint_id - 1 : request.joint_id]
        for field, register in _GAINS.items():
            for name, value in zip(names, getattr(request, field), strict=False):
                self._set(name, register, value)

    def _set_registers(self, request: Any, answer: Any) -> None:
        if request.addr_name not in SETTINGS:
            text = f"register '{request.addr_name}' is not simulated"
            self._commands.report("service_refused", text)
            raise ServiceFailedError(text)
        for name in self._named(request.cmd, request.motor_name):
            self._set(name, request.addr_name, request.value)

    def _set(self, name: str, register: str, value: int) -> None:
        servo = self._servos[name]
        servo.registers[register] = value
        if register == "Profile_Velocity" and value > _LIMIT:
            servo.profile_type = "time"

    def _get_registers(self, request: Any, answer: Any) -> None:
        names = self._named(request.cmd, request.motor_name)
        answer.values = [self._servos[name].registers.get(request.addr_name, 0) for name in names]

    def _torque(self, *, is_on: bool) -> None:
        for servo in self._servos.values():
            servo.torque = is_on
        if not is_on:
            self._commands.report(
                "not_simulated",
                "the servos were torqued off: the twin's joints stay where they are, and take no "
                "commands until they are torqued on",
            )

    # Commands

    def _take_arm(self, topic: str, message: Any) -> None:
        values = [float(value) for value in message.cmd]
        if len(values) < len(self._arm):
            self._streams.refuse(topic, f"{len(values)} commands for {len(self._arm)} joints")
            return
        self._command(topic, self._arm, values[: len(self._arm)], "joint_group_command")

    def _take_single(self, topic: str, message: Any) -> None:
        if message.joint_name not in self._servos:
            self._streams.refuse(topic, f"no servo '{message.joint_name}'")
        elif message.joint_name == GRIPPER:
            self._drive_gripper(topic, float(message.cmd), "position")
        else:
            self._command(topic, (message.joint_name,), [float(message.cmd)], "joint_command")

    def _take_gripper(self, topic: str, message: Any) -> None:
        # Of a mode of positions this topic takes the distance between the fingers.
        self._drive_gripper(topic, float(message.data), "linear_position")

    def _drive_gripper(self, topic: str, value: float, positional: str) -> None:
        servo = self._servos[GRIPPER]
        if not self._gripper_is_set:
            is_pwm = value == 0.0 or abs(value) >= _LEAST_PWM
            servo.mode = "pwm" if is_pwm else positional
        elif servo.mode == "position":
            servo.mode = positional
        self._command(topic, (GRIPPER,), [value], "gripper_command")
