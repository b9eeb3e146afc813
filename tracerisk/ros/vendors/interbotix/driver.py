"""The driver of Interbotix arms on the graph: its services, command topics and joint states.

The services are served in whatever namespace somebody asks for them; there the driver's joint
states are published too, with the gripper's servo among them. Source of the behaviour:
Interbotix/interbotix_ros_core, interbotix_xs_sdk and interbotix_xs_msgs.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tracerisk.errors import one_of
from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.interbotix.dynamixel import MODES, SETTINGS
from tracerisk.ros.vendors.interbotix.servo_node import GRIPPER, TURRET, ServoNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "interbotix_xs_msgs"
_ALL = "all"
_GAINS = {
    "kp_pos": "Position_P_Gain",
    "ki_pos": "Position_I_Gain",
    "kd_pos": "Position_D_Gain",
    "k1": "Feedforward_1st_Gain",
    "k2": "Feedforward_2nd_Gain",
    "kp_vel": "Velocity_P_Gain",
    "ki_vel": "Velocity_I_Gain",
}


class InterbotixDriver(ServoNode):
    """Answers as the xs_sdk node of the twin's arm."""

    node = "/xs_sdk"
    package = PACKAGE

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        servos = tuple(self._servos)
        turret = tuple(name for name in servos if name in TURRET)
        self._groups: dict[str, tuple[str, ...]] = {"arm": self._arm}
        if turret:
            self._groups.update(dict.fromkeys(("turret", "camera"), turret))
        self._groups[_ALL] = servos
        for name, kind, handle in (
            ("get_robot_info", "RobotInfo", self._robot_info),
            ("set_operating_modes", "OperatingModes", self._set_modes),
            ("set_motor_pid_gains", "MotorGains", self._set_gains),
            ("set_motor_registers", "RegisterValues", self._set_registers),
            ("get_motor_registers", "RegisterValues", self._get_registers),
            ("torque_enable", "TorqueEnable", self._torque),
            ("reboot_motors", "Reboot", self._reboot),
        ):
            self._offer(name, f"{PACKAGE}/{kind}", handle)
        self._takers = {
            f"{PACKAGE}/JointGroupCommand": self._take_group,
            f"{PACKAGE}/JointSingleCommand": self._take_single,
            f"{PACKAGE}/JointTrajectoryCommand": self._take_trajectory,
        }
        self._graph.watch(self._on_change)

    # Services

    def _named(self, request: Any) -> tuple[str, ...]:
        """Return the servos that a request is for.

        Raises:
            ServiceFailedError: none is meant.
        """
        if request.cmd_type == "group":
            if request.name in self._groups:
                return self._groups[request.name]
            raise self._refused(f"no group; {one_of(self._groups, request.name)}", request)
        if request.cmd_type == "single":
            if request.name in self._servos:
                return (request.name,)
            raise self._refused(f"no joint; {one_of(self._servos, request.name)}", request)
        raise self._refused(f"cmd_type '{request.cmd_type}'; use 'group' or 'single'", request)

    def _refused(self, message: str, request: Any) -> ServiceFailedError:
        text = f"'{request.name}' of robot '{self._twin.robot.name}': {message}"
        self._commands.report("service_refused", text)
        return ServiceFailedError(text)

    def _robot_info(self, request: Any, answer: Any) -> None:
        names = self._named(request)
        order = self._joint_order()
        first = self._servos[names[0]]
        answer.mode, answer.profile_type = first.mode, first.profile_type
        shown = [self._shown(name) for name in names]
        joints = [self._twin.robot.joint(name) for name in shown]
        answer.joint_names = shown
        answer.joint_ids = [list(self._servos).index(name) + 1 for name in names]
        answer.joint_lower_limits = [joint.lower for joint in joints]
        answer.joint_upper_limits = [joint.upper for joint in joints]
        answer.joint_velocity_limits = [joint.velocity_limit for joint in joints]
        asleep = self._asleep()
        answer.joint_sleep_positions = [asleep.get(name, 0.0) for name in shown]
        answer.joint_state_indices = [order.index(name) for name in shown]
        answer.num_joints = len(names)
        answer.name = list(self._groups) if request.name == _ALL else [request.name]

    def _set_modes(self, request: Any, answer: Any) -> None:
        names = self._named(request)
        if request.mode not in MODES:
            raise self._refused(f"operating mode '{request.mode}'; {one_of(MODES)}", request)
        for name in names:
            servo = self._servos[name]
            servo.mode = request.mode
            servo.profile_type = request.profile_type or servo.profile_type
            servo.registers["Profile_Velocity"] = request.profile_velocity
            servo.registers["Profile_Acceleration"] = request.profile_acceleration

    def _set_gains(self, request: Any, answer: Any) -> None:
        for name in self._named(request):
            for field, register in _GAINS.items():
                self._servos[name].registers[register] = getattr(request, field)

    def _set_registers(self, request: Any, answer: Any) -> None:
        names = self._named(request)
        if request.reg not in SETTINGS:
            raise self._refused(
                f"register '{request.reg}' is not simulated; {one_of(sorted(SETTINGS))}", request
            )
        for name in names:
            self._servos[name].registers[request.reg] = request.value

    def _get_registers(self, request: Any, answer: Any) -> None:
        names = self._named(request)
        if request.reg == "Torque_Enable":
            answer.values = [int(self._servos[name].torque) for name in names]
        elif request.reg == "Hardware_Error_Status":
            answer.values = [0] * len(names)
        elif all(request.reg in self._servos[name].registers for name in names):
            answer.values = [self._servos[name].registers[request.reg] for name in names]
        else:
            raise self._refused(f"register '{request.reg}' is not simulated", request)

    def _torque(self, request: Any, answer: Any) -> None:
        for name in self._named(request):
            self._servos[name].torque = request.enable
        if not request.enable:
            self._commands.report(
                "not_simulated",
                f"'{request.name}' was torqued off: the twin's joints stay where they are, and "
                "take no commands until they are torqued on",
            )

    def _reboot(self, request: Any, answer: Any) -> None:
        names = self._named(request)
        # No servo of the twin is in an error state: a smart reboot finds none.
        if not request.smart_reboot:
            for name in names:
                self._servos[name].torque = request.enable

    # Commands

    def _take_group(self, topic: str, message: Any) -> None:
        names = self._groups.get(message.name)
        if names is None:
            self._streams.refuse(topic, f"no group '{message.name}'; {one_of(self._groups)}")
            return
        if len(message.cmd) != len(names):
            self._streams.refuse(
                topic, f"{len(message.cmd)} commands for the {len(names)} joints of {message.name}"
            )
            return
        self._command(topic, names, [float(item) for item in message.cmd], "joint_group_command")

    def _take_single(self, topic: str, message: Any) -> None:
        if message.name not in self._servos:
            self._streams.refuse(topic, f"no joint '{message.name}'; {one_of(self._servos)}")
            return
        self._command(topic, (message.name,), [float(message.cmd)], "joint_command")

    def _take_trajectory(self, topic: str, message: Any) -> None:
        names = self._groups.get(message.name) if message.cmd_type == "group" else (message.name,)
        if names is None or any(name not in self._servos or name == GRIPPER for name in names):
            self._streams.refuse(topic, f"no joints are meant by '{message.name}'")
            return
        servos = {name: self._servos[name] for name in names}
        if not all(servo.is_positional and servo.torque for servo in servos.values()):
            self._streams.refuse(topic, "its joints are not torqued on in a mode of positions")
            return
        try:
            trajectory = self._motion.through(servos, message.traj.points)
        except ValueError as error:
            self._streams.refuse(topic, str(error))
            return
        self._streams.follow(topic, "joint_trajectory", trajectory, is_set_point=False)
