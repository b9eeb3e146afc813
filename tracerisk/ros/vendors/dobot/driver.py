"""The driver of Dobot's arms with six axes on the graph: the services of dobot_msgs_v4.

Source: Dobot-Arm/DOBOT_6Axis_ROS2_V4, dobot_bringup_v4 (cr_robot_ros2.cpp, parseTool.cpp) and the
list of TCP commands V4 there.
"""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.ros.transforms.poses import compose, shifted
from tracerisk.ros.vendors.dobot.queue import (
    IN_ERROR,
    NOT_EXECUTED,
    OK,
    OUT_OF_RANGE,
    WRONG_TYPE,
    DobotQueue,
    pose_of,
    values_of,
    words_of,
)
from tracerisk.ros.vendors.doosan.motion import DoosanMotion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "dobot_msgs_v4"
_HZ = 10.0
_JOG_M_S, _JOG_RAD_S = 0.25, math.radians(30)  # assumed; ISO 10218-1 allows 250 mm/s by hand
_NOT_SIMULATED = (
    "Pause",
    "Continue",
    "StartPath",
    "StartDrag",
    "RunScript",
    "ForceDriveMode",
    "FCForceMode",
    "FCSetForce",
    "SixForceHome",
    "SetUser",
    "SetTool",
)
_TAKEN = (
    "PowerOn",
    "ResetRobot",
    "SetPayload",
    "SetCollisionLevel",
    "SetToolMode",
    "SetToolPower",
    "CP",
    "AccJ",
    "AccL",
    "RequestControl",
)


Handler = Callable[[Any, Any], int | None]


class DobotDriver(TwinNode):
    """Answers as the driver of the twin's arm; motions go into the queue of its controller."""

    node = "/dobot_bringup_ros2"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands)
        self._queue = DobotQueue(self._arm, self._commands)
        self._pins: dict[tuple[str, int], int] = {}
        self._graph.watch(self._on_change)
        self._arcs = DoosanMotion(self._arm)
        self._streams = CommandStreams(self._commands)
        for name, handle in self._services().items():
            self._offer(f"srv/{name}", f"{PACKAGE}/{name}", handle)

    def _services(self) -> Mapping[str, Handler]:
        queue = self._queue
        return {
            "EnableRobot": partial(self._enable, True),
            "DisableRobot": partial(self._enable, False),
            "ClearError": self._clear,
            "SpeedFactor": lambda asked, _: self._share("factor", asked.ratio),
            "VelJ": lambda asked, _: self._share("joint", asked.r),
            "VelL": lambda asked, _: self._share("line", asked.r),
            "User": self._frame,
            "Tool": self._frame,
            "MovJ": partial(self._to, "MovJ", queue.joint_move, queue.pose_move),
            "MovL": partial(self._to, "MovL", self._line_to_joints, self._line_to),
            "MovJIO": partial(self._to, "MovJIO", queue.joint_move, queue.pose_move),
            "MovLIO": partial(self._to, "MovLIO", self._line_to_joints, self._line_to),
            "Arc": self._arc,
            "Circle": self._circle,
            "ServoJ": self._servo_joints,
            "ServoP": self._servo_pose,
            "RelMovJTool": partial(self._relative, "RelMovJTool", True, queue.pose_move),
            "RelMovLTool": partial(self._relative, "RelMovLTool", True, self._line_to),
            "RelMovJUser": partial(self._relative, "RelMovJUser", False, queue.pose_move),
            "RelMovLUser": partial(self._relative, "RelMovLUser", False, self._line_to),
            "RelJointMovJ": self._relative_joints,
            "MoveJog": self._jog,
            "StopMoveJog": self._stop,
            "Stop": self._stop,
            "EmergencyStop": self._emergency,
            "RobotMode": lambda asked, answer: self._answer(answer, [queue.mode]),
            "GetErrorID": lambda asked, answer: self._answer(answer, [queue.error]),
            "GetCurrentCommandId": lambda asked, answer: self._answer(answer, [queue.done]),
            "GetAngle": self._get_angle,
            "GetPose": self._get_pose,
            "PositiveKin": self._positive,
            "InverseKin": self._inverse,
            "DO": partial(self._set_pin, "DO"),
            "DOInstant": partial(self._set_pin, "DO"),
            "ToolDO": partial(self._set_pin, "ToolDO"),
            "ToolDOInstant": partial(self._set_pin, "ToolDO"),
            "DI": partial(self._get_pin, "DI"),
            "GetDO": partial(self._get_pin, "DO"),
            **{name: partial(self._refuse, name) for name in _NOT_SIMULATED},
            **{name: partial(self._take, name) for name in _TAKEN},
        }

    def _conclude(self, answer: Any, result: Any) -> None:
        answer.res = OK if result is None else result

    # States

    def _enable(self, on: bool, request: Any, answer: Any) -> int:
        if on and self._queue.error:
            return IN_ERROR
        if not on:
            self._queue.stop()
        self._queue.is_enabled = on
        return OK

    def _clear(self, request: Any, answer: Any) -> None:
        self._queue.error = 0
        self._queue.is_stopped = False

    def _share(self, kind: str, percent: int) -> int:
        if not 1 <= percent <= 100:
            return OUT_OF_RANGE
        self._queue.share[kind] = percent / 100.0
        return OK

    def _frame(self, request: Any, answer: Any) -> int:
        return OK if request.index == 0 else self._refuse("a frame other than 0", request, answer)

    def _take(self, name: str, request: Any, answer: Any) -> None:
        self._commands.report("not_simulated", f"{name} was taken and changes nothing")

    def _refuse(self, name: str, request: Any, answer: Any) -> int:
        self._commands.report("not_simulated", f"{name} is not simulated: nothing moved")
        return NOT_EXECUTED

    def _stop(self, request: Any, answer: Any) -> None:
        self._queue.stop()

    def _emergency(self, request: Any, answer: Any) -> None:
        self._queue.is_stopped = bool(request.value)
        if request.value:
            self._queue.stop()
            self._queue.is_enabled = False

    # Motions

    def _add(self, kind: str, asked: Any, make: Callable[[dict[str, float]], Any]) -> int:
        try:
            words = words_of(list(asked.param_value))
        except PlanningError as error:
            return self._wrong(kind, error.message)
        return self._queue.add(kind, lambda: make(words))

    def _wrong(self, kind: str, message: str) -> int:
        self._commands.report("command_ignored", f"{kind} moved nothing: {message}")
        return WRONG_TYPE

    def _to(
        self,
        kind: str,
        by_joints: Callable[[Sequence[float], Mapping[str, float]], JointTrajectory],
        by_pose: Callable[[Pose, Mapping[str, float]], JointTrajectory],
        request: Any,
        answer: Any,
    ) -> int:
        values = _six(request)
        if getattr(request, "mdis", None):
            self._refuse(f"an output along {kind}", request, answer)
        if request.mode:
            self._arm.look_at_degrees(kind, values)
            return self._add(kind, request, lambda words: by_joints(values, words))
        return self._add(kind, request, lambda words: by_pose(pose_of(values), words))

    def _line_to(self, pose: Pose, words: Mapping[str, float]) -> JointTrajectory:
        return self._queue.line([pose], words)

    def _line_to_joints(
        self, degrees: Sequence[float], words: Mapping[str, float]
    ) -> JointTrajectory:
        goal = [math.radians(degree) for degree in degrees]
        self._arm.check(goal)
        return self._queue.line([self._arm.pose_at(goal)], words)

    def _two(self, asked: Any) -> tuple[Pose, Pose]:
        first, second = _six(asked), _six(asked, "2")
        if asked.mode:
            joints = [[math.radians(value) for value in values] for values in (first, second)]
            return self._arm.pose_at(joints[0]), self._arm.pose_at(joints[1])
        return pose_of(first), pose_of(second)

    def _arc(self, request: Any, answer: Any) -> int:
        return self._add(
            "Arc",
            request,
            lambda words: self._queue.line(self._arcs.arc(*self._two(request)), words),
        )

    def _circle(self, request: Any, answer: Any) -> int:
        def make(words: dict[str, float]) -> JointTrajectory:
            first, second = self._two(request)
            here = self._arm.tool_pose()
            once = [*self._arcs.arc(first, second), *self._arcs.arc(first, here, second)]
            return self._queue.line(once * max(1, request.count), words)

        return self._add("Circle", request, make)

    def _relative(
        self,
        kind: str,
        in_tool: bool,
        by_pose: Callable[[Pose, Mapping[str, float]], JointTrajectory],
        request: Any,
        answer: Any,
    ) -> int:
        shift = pose_of(_six(request))

        def make(words: dict[str, float]) -> JointTrajectory:
            here = self._arm.tool_pose()
            if in_tool:
                return by_pose(compose(here, shift), words)
            return by_pose(shifted(here, shift), words)

        return self._add(kind, request, make)

    def _relative_joints(self, request: Any, answer: Any) -> int:
        def make(words: dict[str, float]) -> JointTrajectory:
            here = [math.degrees(position) for position in self._arm.positions()]
            goal = [a + b for a, b in zip(here, _six(request), strict=True)]
            return self._queue.joint_move(goal, words)

        return self._add("RelJointMovJ", request, make)

    def _servo(self, kind: str, request: Any, goal: Callable[[], list[float]]) -> int:
        try:
            words = words_of(list(request.param_value))
        except PlanningError as error:
            return self._wrong(kind, error.message)
        time_s = words.get("t", 0.1)
        if not 0.004 <= time_s <= 3600.0:
            return OUT_OF_RANGE

        code = self._queue.refused()
        if code:
            return self._queue.report_refused(kind, code)
        try:
            values = goal()
            self._arm.check(values)
        except PlanningError as error:
            self._wrong(kind, error.message)
            return NOT_EXECUTED
        self._queue.clear()
        joints, place = self._arm.joints, np.array(values)
        self._streams.to_position(kind, "dobot_servo", joints, place, due_s=time_s)
        return OK

    def _servo_joints(self, request: Any, answer: Any) -> int:
        return self._servo(
            "ServoJ", request, lambda: [math.radians(value) for value in _six(request)]
        )

    def _servo_pose(self, request: Any, answer: Any) -> int:
        return self._servo("ServoP", request, lambda: self._arm.reach(pose_of(_six(request))))

    def _jog(self, request: Any, answer: Any) -> int:
        axis = request.axis_id.strip()
        if not axis:
            self._queue.stop()
            return OK
        name, sign = axis[:-1].upper(), {"+": 1.0, "-": -1.0}.get(axis[-1], 0.0)
        axes = ("X", "Y", "Z", "RX", "RY", "RZ")
        joints = [f"J{i + 1}" for i in range(len(self._arm.joints))]
        if not sign or name not in (*axes, *joints):
            return self._wrong("MoveJog", f"axis '{axis}'; allowed: {', '.join((*axes, *joints))}")
        share = sign * self._queue.share["factor"]

        def make() -> JointTrajectory | None:
            if name in joints:
                speeds = [0.0] * len(joints)
                index = joints.index(name)
                speeds[index] = share * self._arm.arm[index].velocity_limit
                return self._arm.at_speeds(speeds)
            parts = [0.0] * 6
            index = axes.index(name)
            parts[index] = share * (_JOG_M_S if index < 3 else _JOG_RAD_S)
            return self._arm.twist(parts[:3], parts[3:])

        return self._queue.at_once("MoveJog", make)

    # Answers that move nothing

    def _answer(self, answer: Any, values: Sequence[float]) -> int:
        self._scheduler.touch()
        lines = (str(value) if isinstance(value, int) else f"{value:.6f}" for value in values)
        answer.robot_return = "{" + ",".join(lines) + "}"
        return OK

    # Where it is

    def _get_angle(self, request: Any, answer: Any) -> int:
        self._reading.asked("encoder")
        return self._answer(answer, [math.degrees(position) for position in self._arm.positions()])

    def _get_pose(self, request: Any, answer: Any) -> int:
        if request.user or request.tool:
            self._commands.report(
                "not_simulated",
                f"GetPose in user frame {request.user}, tool frame {request.tool}; allowed: 0",
            )
            return NOT_EXECUTED
        self._reading.asked("encoder")
        return self._answer(answer, values_of(self._arm.tool_pose()))

    def _positive(self, request: Any, answer: Any) -> int:
        joints = [math.radians(getattr(request, f"j{i}")) for i in range(1, 7)]
        return self._answer(answer, values_of(self._arm.pose_at(joints)))

    def _inverse(self, request: Any, answer: Any) -> int:
        asked = (request.x, request.y, request.z, request.rx, request.ry, request.rz)
        try:
            reach = self._arm.reach(pose_of(asked))
        except PlanningError:
            return NOT_EXECUTED
        return self._answer(answer, [math.degrees(value) for value in reach])

    def _set_pin(self, place: str, request: Any, answer: Any) -> None:
        self._pins[place, request.index] = int(request.status)
        self._commands.report(
            "not_simulated", f"{place} {request.index} was set: nothing hangs on it"
        )

    def _get_pin(self, place: str, request: Any, answer: Any) -> int:
        return self._answer(answer, [self._pins.get((place, request.index), 0)])

    # Reports

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == f"{PACKAGE}/ToolVectorActual":
            self._report_on(name, type_name, _HZ, self._tool_vector, JOINTS)
        elif change == "subscribed" and type_name == f"{PACKAGE}/RobotStatus":
            self._report_on(name, type_name, _HZ, self._status, JOINTS)

    def _next_ns(self, period_ns: int, *, is_first: bool) -> int:
        return self._scheduler.now_ns + period_ns

    def _tool_vector(self, message: Any, topic: str) -> Any:
        names = ("x", "y", "z", "rx", "ry", "rz")
        for name, value in zip(names, values_of(self._arm.tool_pose()), strict=True):
            setattr(message, name, value)
        return message

    def _status(self, message: Any, topic: str) -> Any:
        message.is_enable, message.is_connected = self._queue.is_enabled, True
        return message


def _six(message: Any, suffix: str = "") -> list[float]:
    return [float(getattr(message, letter + suffix)) for letter in "abcdef"]
