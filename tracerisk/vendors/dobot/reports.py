"""What the driver of a Dobot arm reports and keeps: states, poses, kinematics, pins."""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.vendors.dobot.queue import NOT_EXECUTED, OK, DobotQueue, pose_of, values_of

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "dobot_msgs_v4"

_HZ = 10.0

Handler = Callable[[Any, Any], int]


class DobotReports(TwinNode):
    """Answers what moves nothing, and publishes states while somebody listens."""

    node = "/dobot_bringup_ros2"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands)
        self._queue = DobotQueue(self._arm, self._commands)
        self._pins: dict[tuple[str, int], int] = {}
        self._graph.watch(self._on_change)

    def _services(self) -> Mapping[str, Handler]:
        queue = self._queue
        return {
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
        }

    def _answer(self, answer: Any, values: Sequence[float]) -> int:
        self._scheduler.touch()
        lines = (str(each) if isinstance(each, int) else f"{each:.6f}" for each in values)
        answer.robot_return = "{" + ",".join(lines) + "}"
        return OK

    # Where it is

    def _get_angle(self, request: Any, answer: Any) -> int:
        self._reading.asked("encoder")
        return self._answer(answer, [math.degrees(each) for each in self._arm.positions()])

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
            found = self._arm.reach(pose_of(asked))
        except PlanningError:
            return NOT_EXECUTED
        return self._answer(answer, [math.degrees(each) for each in found])

    def _set_pin(self, place: str, request: Any, answer: Any) -> int:
        self._pins[place, request.index] = int(request.status)
        self._commands.report(
            "not_simulated", f"{place} {request.index} was set: nothing hangs on it"
        )
        return OK

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
