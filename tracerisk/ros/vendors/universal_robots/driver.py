"""The controller box of a UR arm, as it carries out programs that come on a topic.

Each is run from its first line to its last; one that comes meanwhile takes its place. What
branches, or calls what is not known here, moves nothing from there on, and is reported.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.transforms.poses import compose, inverse, rotate, shifted
from tracerisk.ros.vendors.conventions import Conventions
from tracerisk.ros.vendors.universal_robots.script import (
    PoseNumbers,
    ScriptError,
    evaluate,
    statements,
)
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.runtime import Runtime

_TYPE = "std_msgs/String"
_TOPICS = ("script_command", "URScript")
_MODE_TYPE = "ur_msgs/RobotModeDataMsg"
_MODE_TOPIC = "robot_mode_state"
_MODE_HZ = 10.0
"""How often the controller box sends its state, and the drivers of ROS 1 before 2019 pass it on.

Source: ros-industrial/ur_modern_driver src/ros/mb_publisher.cpp.
"""
_SECONDARY = re.compile(r"\s*sec\s")
"""The beginning of a program that runs beside the one by which the driver moves the arm."""
_LOOK_AHEAD_S = (0.03, 0.2)
"""What `servoj` takes for its `lookahead_time` [s]."""
_LAST_JOINT = "wrist_3_joint"
_BASE = "base"
_OUTPUTS = (
    *("set_digital_out", "set_standard_digital_out", "set_configurable_digital_out"),
    *("set_tool_digital_out", "set_analog_out", "set_standard_analog_out", "set_tool_voltage"),
    *("textmsg", "popup", "sync", "set_payload", "set_gravity"),
)
"""What moves nothing of the twin."""
_NOWHERE = Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


class ScriptTopics(TwinNode):
    """Listens to topics of programs where the robot is a UR arm."""

    node = "/ur_hardware_interface"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._running: _Program | None = None
        self._box = _Box(CommandStreams(self._commands))
        self._states = runtime.client(ControllerStates)
        if any(joint.name.endswith(_LAST_JOINT) for joint in self._twin.robot.arm_joints):
            self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "advertised" and type_name == _TYPE and name.rsplit("/", 1)[-1] in _TOPICS:
            self._hear(name, type_name, self._take)
        if change == "subscribed" and type_name == _MODE_TYPE and name.endswith(_MODE_TOPIC):
            self._report_on(name, type_name, _MODE_HZ, lambda message, _: self._mode(message))

    def _mode(self, message: Any) -> Any:
        """Fill a message that says whether a program runs."""
        message.is_robot_connected = message.is_real_robot_enabled = True
        message.is_power_on_robot = True
        message.is_program_running = self._running is not None and not self._running.is_over
        return message

    def _take(self, message: Any, publication: Publication) -> None:
        if not publication.by_controller:
            return
        topic = publication.topic
        text = str(message.data)
        if self._box.starts != self._states.starts:
            # The program of the driver begins with what the installation has.
            self._box.tcp, self._box.starts = _NOWHERE, self._states.starts
        if not _SECONDARY.match(text):
            self._states.script_came(topic)
        before, self._running = self._running, _Program(self._commands, self._box, topic, text)
        if before is not None:
            before.give_way()
        self._running.go_on()
        if before is not None and not self._running.is_moving:
            # A motion of the new one takes the joints from where they are, as fast as they go.
            self._running.rest()


@dataclass(slots=True)
class _Box:
    """What stays when a program is over."""

    streams: CommandStreams
    """What follows set-points and velocities, of one program after the other."""
    tcp: Pose = _NOWHERE
    """The tool centre point, as seen from the flange."""
    starts: int = 0
    """How often the program of the driver had been started again when it was set."""


class _Program:
    """One program while it runs; all that it moves is commanded by who sent it."""

    def __init__(self, commands: TwinCommands, box: _Box, topic: str, text: str) -> None:
        self._commands = commands
        self._box = box
        self._scheduler = commands.scheduler
        self._stack: tuple[Frame, ...] = commands.stack()
        self._topic = topic
        self._arm = ArmMotion(commands)
        self._turns = Conventions(rotation="rotation_vector")
        self._names: dict[str, Any] = {}
        self._goes_on = False
        self.is_over = False
        self.is_moving = False
        self._is_busy = False
        self._steps = self._run(text)
        self._functions: dict[str, Callable[..., Any]] = {
            "movej": self._movej,
            "movel": self._movel,
            "movep": self._movel,
            "servoj": self._servoj,
            "speedj": self._speedj,
            "speedl": self._speedl,
            "stopj": self._stop,
            "stopl": self._stop,
            "sleep": self._sleep,
            "set_tcp": self._set_tcp,
            "get_actual_tcp_pose": self._tcp_pose,
            "get_target_tcp_pose": self._tcp_pose,
            "get_actual_joint_positions": self._arm.positions,
            "get_target_joint_positions": self._arm.positions,
            "get_inverse_kin": lambda pose, *_: self._goal(pose),
            "pose_trans": lambda a, b: self._numbers(compose(self._pose(a), self._pose(b))),
            "pose_inv": lambda a: self._numbers(inverse(self._pose(a))),
            "pose_add": self._pose_add,
            "d2r": math.radians,
            "r2d": math.degrees,
            **dict.fromkeys(_OUTPUTS, lambda *_, **__: None),
        }

    def give_way(self) -> None:
        """End where another program takes its place, which has the arm from then on."""
        self.is_over, self._goes_on = True, False

    def rest(self) -> None:
        """Bring the arm to rest."""
        self._arm.stop()

    def go_on(self) -> None:
        """Carry out statements up to the next motion."""
        while not self.is_over and not self._is_busy:
            self.is_over = next(self._steps, None) is None
        if self.is_over and self._goes_on:
            # What turns at a velocity stops with its program.
            self._goes_on = False
            self._arm.stop()

    def _run(self, text: str) -> Iterator[bool]:
        try:
            for statement in statements(text):
                result = evaluate(statement, self._names, self._functions)
                if statement.name:
                    self._names[statement.name] = result
                yield True
        except ScriptError as error:
            self._report("unprovided", str(error))
        except PlanningError as error:
            self._report("command_ignored", error.message)

    def _report(self, kind: str, message: str) -> None:
        self._commands.report(
            kind,
            f"a program on {self._topic} moved nothing from here on: {message}",
            self._stack,
            object_name=self._topic,
            may_stream=True,
        )

    # Motions

    def _follow(self, kind: str, trajectory: JointTrajectory | None) -> None:
        if trajectory is None:
            self._arm.stop()
            return
        self._is_busy = self.is_moving = True
        self._arm.start(kind, trajectory, self._stack, self._ended)

    def _ended(self, motion: Motion) -> None:
        self.is_over = self.is_over or motion.outcome != "succeeded"
        self._resume_at(self._scheduler.now_ns)

    def _resume_at(self, due_ns: int) -> None:
        def resume() -> None:
            self._is_busy = False
            self.go_on()

        self._is_busy = True
        self._scheduler.call_at(due_ns, resume)

    def _movej(
        self, target: Any, a: float = 1.4, v: float = 1.05, t: float = 0.0, r: float = 0.0
    ) -> None:
        del r  # a blend only rounds the corner between two motions
        count = len(self._arm.joints)
        goal = self._goal(target)
        made = self._arm.to_joints(goal, speeds=[v] * count, rises=[a] * count, duration_s=t)
        self._follow("movej", made)

    def _movel(
        self, target: Any, a: float = 1.2, v: float = 0.25, t: float = 0.0, r: float = 0.0
    ) -> None:
        del a, r
        is_pose = isinstance(target, PoseNumbers)
        pose = self._tool_at(target) if is_pose else self._arm.pose_at(target)
        self._follow("movel", self._arm.line([pose], speed=v, duration_s=t))

    def _servoj(
        self,
        target: Any,
        a: float = 0.0,
        v: float = 0.0,
        t: float = 0.002,
        lookahead_time: float = 0.1,
        gain: float = 300.0,
    ) -> None:
        del a, v, gain  # the first two are not used by the box either
        goal = self._goal(target)
        self._arm.check(goal)
        self.is_moving = True
        self._box.streams.to_position(
            self._topic,
            "servoj",
            self._arm.joints,
            np.array(goal),
            due_s=t,
            look_ahead_s=min(max(lookahead_time, _LOOK_AHEAD_S[0]), _LOOK_AHEAD_S[1]),
            stack=self._stack,
        )
        self._sleep(t)

    def _speedj(self, speeds: Sequence[float], a: float = 40.0, t: float = 0.0) -> None:
        asked = dict(zip(self._arm.joints, map(float, speeds), strict=False))
        now = dict(zip(self._arm.joints, self._arm.velocities(), strict=True))
        change = max((abs(speed - now[name]) for name, speed in asked.items()), default=0.0)
        self.is_moving = self._goes_on = True
        self._box.streams.go_on_at(self._topic, "speedj", asked, None, stack=self._stack)
        # Without a time it returns when the joints are as fast as they are to be.
        self._sleep(t or change / max(a, 1e-3))

    def _speedl(self, speeds: Sequence[float], a: float = 1.2, t: float = 0.0) -> None:
        del a
        turn = self._base().orientation
        linear, angular = rotate(turn, speeds[:3]), rotate(turn, speeds[3:])
        made = self._arm.twist(linear, angular, for_s=t or None)
        self._follow("speedl", made)

    def _stop(self, *_: float) -> None:
        self._arm.stop()

    def _sleep(self, seconds: float) -> None:
        self._resume_at(self._scheduler.now_ns + round(max(seconds, 0.0) * 1e9))

    # Poses, which are in the frame of the controller box

    def _set_tcp(self, pose: Any) -> None:
        self._box.tcp = self._pose(pose)

    def _base(self) -> Pose:
        names = self._arm.twin.robot.link_names
        link = next((name for name in names if name.endswith(_BASE)), None)
        return _NOWHERE if link is None else self._arm.twin.link_pose(link)

    def _pose(self, numbers: Sequence[float]) -> Pose:
        return self._turns.pose(numbers)

    def _numbers(self, pose: Pose) -> PoseNumbers:
        return PoseNumbers(self._turns.pose_numbers(pose))

    def _tcp_pose(self) -> PoseNumbers:
        seen = compose(inverse(self._base()), self._arm.tool_pose())
        return self._numbers(compose(seen, self._box.tcp))

    def _tool_at(self, numbers: Sequence[float]) -> Pose:
        return compose(self._base(), compose(self._pose(numbers), inverse(self._box.tcp)))

    def _goal(self, target: Any) -> list[float]:
        if isinstance(target, PoseNumbers):
            return self._arm.reach(self._tool_at(target), self._arm.positions())
        return [float(item) for item in target]

    def _pose_add(self, one: Any, other: Any) -> PoseNumbers:
        return self._numbers(shifted(self._pose(other), self._pose(one)))
