"""What the driver of a Dobot arm reports and keeps: states, poses, kinematics, pins."""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change, Publication
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.vendors.dobot.queue import NOT_EXECUTED, OK, DobotQueue, pose_of, values_of

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "dobot_msgs_v4"

_NODE = "/dobot_bringup_ros2"
_HZ = 10.0

Handler = Callable[[Any, Any], int]


class DobotReports:
    """Answers what moves nothing, and publishes states while somebody listens."""

    def __init__(
        self,
        runtime: Runtime,
        messages: TwinMessages,
        commands: TwinCommands,
        queue: DobotQueue,
    ) -> None:
        self._graph, self._scheduler = runtime.graph, runtime.scheduler
        self._messages = messages
        self._commands = commands
        self._queue, self._arm = queue, queue.arm
        self._reading = runtime.client(SensorReading)
        self._pins: dict[tuple[str, int], int] = {}
        self._published: set[str] = set()
        self._reports: Mapping[str, Callable[[Any], Any]] = {
            f"{PACKAGE}/ToolVectorActual": self._tool_vector,
            f"{PACKAGE}/RobotStatus": self._status,
        }
        self._graph.watch(self._on_change)

    def services(self) -> Mapping[str, Handler]:
        """Return the handlers by the names of the services."""
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
        is_one = change == "subscribed" and type_name in self._reports
        if is_one and name not in self._published:
            self._published.add(name)
            publication = self._graph.advertise(name, type_name, node=_NODE, by_controller=False)
            self._reading.reports_joints(publication, _HZ)
            self._schedule(publication)

    def _schedule(self, publication: Publication) -> None:
        due_ns = self._scheduler.now_ns + round(1e9 / _HZ)
        self._scheduler.call_at(due_ns, lambda: self._report(publication), background=True)

    def _report(self, publication: Publication) -> None:
        if not publication.subscriptions:
            self._published.discard(publication.topic)
            publication.close()
            return
        make = self._reports[publication.type_name]
        publication.publish(make(self._messages.new(publication.type_name)))
        self._schedule(publication)

    def _tool_vector(self, message: Any) -> Any:
        names = ("x", "y", "z", "rx", "ry", "rz")
        for name, value in zip(names, values_of(self._arm.tool_pose()), strict=True):
            setattr(message, name, value)
        return message

    def _status(self, message: Any) -> Any:
        message.is_enable, message.is_connected = self._queue.is_enabled, True
        return message
