"""The driver of a Baxter on the graph: joint commands, states, grippers, head and IK services.

Source: RethinkRobotics/baxter_common (baxter_core_msgs), baxter_interface (limb.py, gripper.py),
baxter_simulator (baxter_sim_hardware/baxter_emulator.cpp) and the SDK's wiki, "Arm Control Modes".
"""

# ruff: noqa: ARG002 - what reports a state is called with its topic
from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.moveit.messages import set_pose
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.robot.grippers import measured_grip
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot_parts import Gripper

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_CORE, _INTERA = "baxter_core_msgs", "intera_core_msgs"
_POSITION, _VELOCITY, _TORQUE, _RAW = 1, 2, 3, 4  # JointCommand.mode
_HZ = 100.0
_SPEED = 0.3  # the fraction of the rated speed, before set_speed_ratio
_TIMEOUT_S = 0.2  # of velocities, before joint_command_timeout
_ELECTRIC = 2
_SIDE = re.compile(r"/(left|right)(?:_gripper)?/")
_IO = re.compile(r"^/robot/\w+/(\w+?)(?:_navigator)?/state$")
_STARTED = "/robot/sim/started"  # baxter_simulator says so once, when its robot takes commands
_INPUT = re.compile(r"button|cuff|sensor|sonar")
_LOOK_S = 1e-3
_NUMBERS = ("position", "moving_force")
_OF_JOINTS = (
    *("sensor_msgs/JointState", f"{_CORE}/EndpointState"),
    *(f"{_CORE}/HeadState", f"{_INTERA}/HeadState"),
)


class BaxterDriver(TwinNode):
    """Takes a Baxter's commands and reports its state; the robot is enabled when the run begins."""

    node = "/realtime_loop"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._streams = CommandStreams(self._commands)
        self._enabled, self._stopped = True, False
        self._speed: dict[str, float] = {}
        self._timeout_s: dict[str, float] = {}
        self._grips: dict[str, tuple[str, str, int]] = {}
        self._calibrated: dict[str, bool] = {}
        self._forces: dict[str, float] = {}
        self._outputs: dict[str, float] = {}
        self._takers: dict[str, Callable[[str, Any], None]] = {
            f"{_CORE}/JointCommand": self._take_joints,
            f"{_CORE}/EndEffectorCommand": self._take_gripper,
            f"{_CORE}/HeadPanCommand": self._take_head,
            f"{_INTERA}/HeadPanCommand": self._take_head,
            f"{_CORE}/DigitalOutputCommand": self._take_output,
            f"{_CORE}/AnalogOutputCommand": self._take_output,
            "std_msgs/Float64": self._take_number,
            "std_msgs/Bool": self._take_enable,
            "std_msgs/Empty": self._take_empty,
        }
        self._tellers: dict[str, Callable[[Any, str], Any]] = {
            f"{_CORE}/AssemblyState": self._assembly,
            f"{_CORE}/EndpointState": self._endpoint,
            f"{_CORE}/EndEffectorState": self._gripper_state,
            f"{_CORE}/EndEffectorProperties": self._gripper_properties,
            f"{_CORE}/DigitalIOState": self._digital,
            f"{_CORE}/AnalogIOState": self._analog,
            f"{_CORE}/NavigatorState": self._navigator,
            f"{_CORE}/HeadState": self._head,
            f"{_INTERA}/HeadState": self._head,
            "sensor_msgs/JointState": self._joint_states,
        }
        joints = {joint.name for joint in self._twin.robot.joints}
        sides = [side for side in ("left", "right") if f"{side}_s0" in joints]
        self._is_there = bool(sides) or "right_j0" in joints  # a Baxter, or a Sawyer
        for side in sides:
            self._graph.services.serve(
                f"/ExternalTools/{side}/PositionKinematicsNode/IKService",
                f"{_CORE}/SolvePositionIK",
                partial(self._solve, f"{side}_arm"),
                node=self.node,
                is_callback=False,
            )
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        # Other robots, too, are in a namespace `robot`: only the maker's own types are his there.
        if not name.startswith("/robot/") or not (self._is_there or type_name.startswith(_CORE)):
            return
        if change == "advertised" and type_name in self._takers:
            take = self._takers[type_name]
            self._hear(name, type_name, lambda message, _: take(name, message))
        elif change == "subscribed" and type_name in self._tellers:
            sensors = JOINTS if type_name in _OF_JOINTS else ()
            self._report_on(name, type_name, _HZ, self._tellers[type_name], sensors)
        elif change == "subscribed" and name == _STARTED and name not in self._reported:
            self._reported.add(name)
            started = self._graph.advertise(
                name, type_name, node=self.node, latch=True, by_controller=False
            )
            started.publish(self._messages.new(type_name))

    # Commands

    def _take_number(self, topic: str, message: Any) -> None:
        side = _side(topic)
        if topic.endswith("/set_speed_ratio"):
            self._speed[side] = min(max(float(message.data), 1e-3), 1.0)
        elif topic.endswith("/joint_command_timeout"):
            self._timeout_s[side] = float(message.data)

    def _take_output(self, topic: str, message: Any) -> None:
        if not _INPUT.search(message.name):
            self._outputs[message.name] = float(message.value)

    def _take_enable(self, topic: str, message: Any) -> None:
        if not topic.endswith("/set_super_enable"):
            return
        self._enabled = bool(message.data) and not self._stopped
        if not self._enabled:
            self._commands.rest()

    def _take_empty(self, topic: str, message: Any) -> None:
        del message
        if topic.endswith("/set_super_stop"):
            self._stopped, self._enabled = True, False
            self._commands.rest()
        elif topic.endswith("/set_super_reset"):
            self._stopped = self._enabled = False

    def _take_joints(self, topic: str, message: Any) -> None:
        asked = dict(zip(message.names, map(float, message.command), strict=False))
        known = {joint.name: joint for joint in self._twin.robot.joints}
        unknown = [name for name in asked if name not in known]
        fault = ""
        if not self._enabled:
            fault = "the robot is not enabled"
        elif unknown or not asked:
            fault = f"no joint '{next(iter(unknown), '')}'; {one_of(known)}"
        elif not np.isfinite(list(asked.values())).all():
            fault = "a command is not finite"
        elif message.mode == _TORQUE:
            fault = "commands of torque are not simulated, only positions and velocities"
        if fault:
            self._streams.refuse(topic, fault)
        elif message.mode == _VELOCITY:
            for_s = self._timeout_s.get(_side(topic), _TIMEOUT_S)
            self._streams.go_on_at(topic, "joint_velocity_command", asked, for_s, is_timeout=True)
        else:
            joints = tuple(asked)
            target = np.array([min(max(asked[n], known[n].lower), known[n].upper) for n in joints])
            speed = self._speed.get(_side(topic), _SPEED)
            self._streams.to_position(topic, "joint_command", joints, target, speed=speed)

    def _take_head(self, topic: str, message: Any) -> None:
        name = next((j.name for j in self._twin.robot.joints if j.name == "head_pan"), None)
        if name is None or not self._enabled:
            self._streams.refuse(topic, "the robot has no head that pans, or is not enabled")
            return
        joint = self._twin.robot.joint(name)
        target = np.array([min(max(float(message.target), joint.lower), joint.upper)])
        speed = min(max(float(message.speed_ratio), 0.05), 1.0)
        self._streams.to_position(topic, "head_pan", (name,), target, speed=speed)

    def _take_gripper(self, topic: str, message: Any) -> None:
        side, gripper = _side(topic), self._gripper(topic)
        acknowledged = self._grips.get(side, ("", "", 0))
        received = (message.command, message.sender, message.sequence)
        if gripper is None or received == acknowledged:
            return
        self._grips[side] = received
        try:
            asked = _numbers(message.args)
        except (TypeError, ValueError):
            self._streams.refuse(topic, f"args '{message.args}' are no numbers by name, as JSON")
            return
        if message.command == "configure":
            self._forces[side] = asked.get("moving_force", 40.0)
        elif message.command in ("calibrate", "clear_calibration", "reboot", "reset"):
            self._calibrated[side] = message.command in ("calibrate", "reset")
        elif message.command == "stop":
            self._commands.rest(gripper.joints)
        elif message.command in ("go", "grip", "release"):
            by_name = 0.0 if message.command == "grip" else 100.0
            self._grip(topic, gripper, asked.get("position", by_name))

    def _grip(self, topic: str, gripper: Gripper, percent: float) -> None:
        part = min(max(percent, 0.0), 100.0) / 100
        goal = gripper_ends(self._twin.robot, gripper).position(part)
        effort = gripper.effort * max(self._forces.get(_side(topic), 40.0), 1.0) / 100
        try:
            motion = self._twin.move_gripper(gripper.name, goal, max_effort=effort)
        except PlanningError as error:
            self._streams.refuse(topic, error.message)
            return
        self._commands.begin("gripper_command", motion, self._commands.stack())

    def _gripper(self, topic: str) -> Gripper | None:
        side = _side(topic)
        return next((g for g in self._twin.robot.grippers if g.name.startswith(side)), None)

    # States

    def _assembly(self, message: Any, topic: str) -> Any:
        message.ready, message.enabled, message.stopped = True, self._enabled, self._stopped
        return message

    def _joint_states(self, message: Any, topic: str) -> Any:
        self._now(message.header)
        state = self._twin.joint_state()
        present = [i for i, name in enumerate(state.names) if name not in state.absent]
        message.name = [state.names[i] for i in present]
        message.position = [state.position[i] for i in present]
        message.velocity = [state.velocity[i] for i in present]
        message.effort = [state.effort[i] for i in present]
        return message

    def _endpoint(self, message: Any, topic: str) -> Any:
        robot, side = self._twin.robot, _side(topic)
        group = robot.groups.get(f"{side}_arm")
        link = f"{side}_gripper" if f"{side}_gripper" in robot.link_names else None
        link = link or (group.tip_link if group is not None else None)
        if link is None:
            return None
        state = self._twin.joint_state()
        here = self._twin.link_pose(link)
        soon = self._twin.forward_kinematics(
            {
                name: at + _LOOK_S * rate
                for name, at, rate in zip(state.names, state.position, state.velocity, strict=True)
            },
            link,
        )
        self._now(message.header)
        set_pose(message.pose, here)
        linear = message.twist.linear
        linear.x, linear.y, linear.z = (
            (b - a) / _LOOK_S for a, b in zip(here.position, soon.position, strict=True)
        )
        return message

    def _gripper_properties(self, message: Any, topic: str) -> Any:
        if self._gripper(topic) is not None:
            message.id, message.ui_type = 65538, _ELECTRIC
            message.manufacturer, message.product = "Rethink Research Robot", "Electric Gripper"
            for field in ("has_calibration", "controls_grip", "senses_grip", "controls_force",
                          "controls_position", "senses_position"):  # fmt: skip
                setattr(message, field, True)
        return message

    def _gripper_state(self, message: Any, topic: str) -> Any:
        gripper, side = self._gripper(topic), _side(topic)
        set_time(message.timestamp, EPOCH_NS + self._scheduler.now_ns)
        if gripper is None:
            return message
        position, speed, effort = measured_grip(self._twin.joint_state(), gripper)
        message.id, message.enabled, message.ready = 65538, int(self._enabled), 1
        message.calibrated = int(self._calibrated.get(side, True))
        message.moving = int(speed > 1e-3)
        message.position = 100.0 * gripper_ends(self._twin.robot, gripper).share(position)
        command, sender, sequence = self._grips.get(side, ("", "", 0))
        # Fingers that press and stand still between their ends hold something.
        holds = effort > 0.1 * gripper.effort and 2.0 < message.position < 98.0
        message.gripping = int(holds and not message.moving)
        message.missed = int(command == "grip" and not holds and not message.moving)
        message.force = min(100.0, 100.0 * effort / gripper.effort)
        message.command, message.command_sender = command, sender
        message.command_sequence = sequence
        return message

    def _head(self, message: Any, topic: str) -> Any:
        state = self._twin.joint_state()
        if "head_pan" not in state.names:
            return None
        index = state.names.index("head_pan")
        message.pan, message.isTurning = state.position[index], abs(state.velocity[index]) > 0.01
        if hasattr(message, "isPanEnabled"):
            message.isPanEnabled = True  # a Sawyer's has a mode instead
        return message

    def _digital(self, message: Any, topic: str) -> Any:
        name = _io_name(topic)
        message.state, message.isInputOnly = self._state_of(name), bool(_INPUT.search(name))
        return message

    def _analog(self, message: Any, topic: str) -> Any:
        name = _io_name(topic)
        set_time(message.timestamp, EPOCH_NS + self._scheduler.now_ns)
        message.value = self._outputs.get(name, 0.0)
        message.isInputOnly = bool(_INPUT.search(name))
        return message

    def _navigator(self, message: Any, topic: str) -> Any:
        """Return a navigator of which nobody presses a button or turns the wheel."""
        name = _io_name(topic)
        message.button_names, message.buttons = ["ok", "cancel", "show"], [False] * 3
        message.light_names = ["inner", "outer"]
        message.lights = [
            bool(self._state_of(f"{name}_itb_light_{light}")) for light in message.light_names
        ]
        return message

    def _state_of(self, name: str) -> int:
        return int(self._outputs.get(name, 0.0) != 0.0)

    # Kinematics

    def _solve(self, group: str, request: Any) -> Any:
        answer = self._messages.response(f"{_CORE}/SolvePositionIK")
        joints, valid = [], []
        for index, stamped in enumerate(request.pose_stamp):
            message = self._messages.new("sensor_msgs/JointState")
            seeds = request.seed_angles
            seed = seeds[index] if index < len(seeds) and seeds[index].name else None
            try:
                inverse_kinematics = self._twin.inverse_kinematics(
                    group,
                    message_pose(stamped.pose),
                    seed=None if seed is None else dict(zip(seed.name, seed.position, strict=True)),
                )
                message.name, message.position = (
                    list(inverse_kinematics),
                    list(inverse_kinematics.values()),
                )
                valid.append(True)
            except (PlanningError, RobotError):
                valid.append(False)
            joints.append(message)
        answer.joints, answer.isValid = joints, valid
        answer.result_type = bytes(int(flag) for flag in valid)
        return answer


def _numbers(text: str) -> dict[str, float]:
    """Return the numbers in the arguments of a gripper's command; raise ValueError or TypeError."""
    asked = json.loads(text) if text else {}
    if not isinstance(asked, dict):
        raise ValueError("no mapping")
    return {name: float(value) for name, value in asked.items() if name in _NUMBERS}


def _side(topic: str) -> str:
    matched = _SIDE.search(topic)
    return matched.group(1) if matched else ""


def _io_name(topic: str) -> str:
    """Return the component of a topic: `left_cuff` of `/robot/digital_io/left_cuff/state`."""
    matched = _IO.match(topic)
    return "" if matched is None else matched[1]
