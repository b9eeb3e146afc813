"""The driver of Interbotix arms on the graph: its services, command topics and joint states.

The services are served in whatever namespace somebody asks for them; there the driver's joint
states are published too, with the gripper's servo among them. Source of the behaviour:
Interbotix/interbotix_ros_core, interbotix_xs_sdk and interbotix_xs_msgs.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import one_of
from tracerisk.ros.graph.graph import Change, Publication, ServiceFailedError
from tracerisk.ros.robot.command_streams import CommandStreams
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.motion_profiles import at_velocities
from tracerisk.ros.robot.set_points import JOINT_STATE_TYPE
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.vendors.interbotix.dynamixel import LARGEST, MODES, SETTINGS, Servo, linkage_of
from tracerisk.vendors.interbotix.motion import InterbotixMotion

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.robot import Gripper

PACKAGE = "interbotix_xs_msgs"
GRIPPER = "gripper"
"""The name of the servo that drives the fingers; arms of the series have one."""

_HZ = 100.0  # joint_state_publisher.update_rate of interbotix_xsarm_control/config
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


class InterbotixDriver(TwinNode):
    """Answers as the xs_sdk node of the twin's arm."""

    node = "/xs_sdk"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        robot = self._twin.robot
        self._gripper: Gripper | None = next(iter(robot.grippers), None)
        # A description may have a joint for the servo of the gripper, which only turns a picture.
        servos = tuple(joint.name for joint in robot.arm_joints if joint.name != GRIPPER)
        turret = tuple(name for name in servos if name in ("pan", "tilt"))
        self._groups: dict[str, tuple[str, ...]] = {
            "arm": tuple(name for name in servos if name not in turret)
        }
        if turret:
            self._groups["turret"] = turret
        if self._gripper is not None:
            servos += (GRIPPER,)
        self._groups[_ALL] = servos
        self._servos = {name: Servo() for name in servos}
        if self._gripper is not None:
            self._servos[GRIPPER] = Servo("pwm", "velocity", True, dict.fromkeys(SETTINGS, 0))
        self._linkage = linkage_of(robot.name)
        self._streams = CommandStreams(self._commands)
        self._motion = InterbotixMotion(self._twin)
        self._publications: dict[str, Publication] = {}
        self._ticked: dict[str, int] = {}
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

    # What is found on the graph

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "served" and type_name.startswith(f"{PACKAGE}/"):
            self._publish_states(name.rsplit("/", 1)[0] + "/joint_states")
        elif change == "advertised" and type_name in self._takers:
            take = self._takers[type_name]
            self._hear(name, type_name, lambda message, _: take(name, message))
        elif change == "subscribed" and type_name == JOINT_STATE_TYPE:
            spaces = [topic.rsplit("/", 1)[0] for topic in self._publications]
            if any(space and name.startswith(space + "/") for space in spaces):
                # Robots of several drivers publish below their namespace.
                self._publish_states(name)
            if name in self._publications:
                self._go_on(name)

    def _publish_states(self, topic: str) -> None:
        # The twin's own joint states need no second publisher.
        if topic not in self._publications and topic != "/joint_states":
            advertised = self._graph.advertise(
                topic, JOINT_STATE_TYPE, node=self.node, by_controller=False
            )
            self._publications[topic] = advertised
            self._reading.reports_joints(advertised, _HZ)
            self._go_on(topic)

    def _go_on(self, topic: str) -> None:
        period_ns = round(1e9 / _HZ)
        due_ns = (self._scheduler.now_ns // period_ns + 1) * period_ns
        self._scheduler.call_at(due_ns, lambda: self._publish(topic, due_ns), background=True)

    def _publish(self, topic: str, due_ns: int) -> None:
        publication = self._publications[topic]
        if publication.is_wanted and self._ticked.get(topic, -1) < due_ns:
            self._ticked[topic] = due_ns
            publication.publish(self._joint_state())
            self._go_on(topic)

    def _joint_state(self) -> Any:
        state = self._twin.joint_state()
        message = self._messages.new(JOINT_STATE_TYPE)
        self._now(message.header)
        present = [each for each in self._joint_order() if each not in state.absent]
        message.name = self._graph.carrier.world.ordered(present)
        values = {
            name: (state.position[i], state.velocity[i], state.effort[i])
            for i, name in enumerate(state.names)
        }
        if self._gripper is not None:
            finger, speed, effort = values[self._gripper.joints[0]]
            angle = self._linkage.angle(abs(finger))
            ahead = self._linkage.angle(abs(finger) + 1e-6)
            values[GRIPPER] = angle, speed * (ahead - angle) * 1e6, effort
        rows = [values[name] for name in message.name]
        message.position = [row[0] for row in rows]
        message.velocity = [row[1] for row in rows]
        message.effort = [row[2] for row in rows]
        return message

    def _joint_order(self) -> list[str]:
        fingers = () if self._gripper is None else self._gripper.joints
        return [*self._servos, *fingers]

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

    def _shown(self, servo: str) -> str:
        return self._gripper.joints[0] if servo == GRIPPER and self._gripper else servo

    def _asleep(self) -> dict[str, float]:
        robot = self._twin.robot
        asleep = dict(robot.initial_state)
        for states in robot.named_states.values():
            for name, state in states.items():
                if name.lower() == "sleep":
                    asleep.update(state)
        return asleep

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
        self._command(topic, names, [float(each) for each in message.cmd], "joint_group_command")

    def _take_single(self, topic: str, message: Any) -> None:
        if message.name not in self._servos:
            self._streams.refuse(topic, f"no joint '{message.name}'; {one_of(self._servos)}")
            return
        self._command(topic, (message.name,), [float(message.cmd)], "joint_command")

    def _command(
        self, topic: str, names: Sequence[str], values: Sequence[float], kind: str
    ) -> None:
        limp = [name for name in names if not self._servos[name].torque]
        if limp:
            self._streams.refuse(topic, f"{', '.join(limp)} is torqued off")
            return
        if not np.isfinite(values).all():
            self._streams.refuse(topic, "a command is not finite")
            return
        asked = dict(zip(names, values, strict=True))
        if GRIPPER in asked:
            self._command_gripper(topic, asked.pop(GRIPPER))
        servos = {name: self._servos[name] for name in asked}
        if not servos:
            return
        if all(servo.is_positional for servo in servos.values()):
            made = self._motion.to_positions(servos, asked)
            self._streams.follow(f"{topic} {' '.join(asked)}", kind, made[0], is_set_point=made[1])
        elif all(servo.mode == "velocity" for servo in servos.values()):
            moving = at_velocities(self._twin, asked)
            if moving is None:
                self._commands.rest(list(asked))
            else:
                key = f"{topic} {' '.join(asked)}"
                self._streams.follow(key, "joint_velocity_command", moving, is_set_point=True)
        else:
            modes = ", ".join(sorted({servo.mode for servo in servos.values()}))
            self._streams.refuse(topic, f"commands in the mode {modes} are not simulated")

    def _command_gripper(self, topic: str, value: float) -> None:
        gripper, servo = self._gripper, self._servos[GRIPPER]
        assert gripper is not None
        effort = None
        if servo.mode in LARGEST:
            if value == 0.0:
                # The gear holds what the fingers hold; nothing drives them on.
                return
            ends = gripper_ends(self._twin.robot, gripper)
            goal = ends.opened if value > 0.0 else ends.closed
            effort = gripper.effort * min(1.0, abs(value) / LARGEST[servo.mode])
        elif servo.is_positional:
            finger = value / 2 if servo.mode == "linear_position" else self._linkage.finger(value)
            goal = min(max(finger, gripper.least), gripper.opening)
        else:
            self._streams.refuse(topic, f"a gripper in the mode {servo.mode} is not simulated")
            return
        try:
            motion = self._twin.move_gripper(gripper.name, goal, max_effort=effort)
        except PlanningError as error:
            self._streams.refuse(topic, error.message)
            return
        self._commands.begin("gripper_command", motion, self._commands.stack())

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
