"""What moves a Doosan arm on the graph: the services of dsr_msgs2, and of dsr_msgs.

Source: DoosanRobotics/doosan-robot2, dsr_msgs2 and dsr_common2/imp/DSR_ROBOT2.py. In ROS 1
(doosan-robotics/doosan-robot, dsr_control/src/dsr_hw_interface.cpp) the same fields are written
`syncType`, and the names of pins leave out the box.
"""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import SHORT_S, CommandStreams
from tracerisk.ros.vendors.doosan.motion import pose_of
from tracerisk.ros.vendors.doosan.reports import DoosanReports, Handler
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.runtime import Runtime

_OF_ROS1 = "dsr_msgs"
PACKAGES = ("dsr_msgs2", _OF_ROS1)

_TYPES = {
    "robotiq_2f_open": "Robotiq2FOpen",
    "robotiq_2f_close": "Robotiq2FClose",
}
_CIRCLE, _AXES = 1, 6


class DoosanController(DoosanReports):
    """Answers as the controller of the twin's arm; a motion waits for the end of the one before."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._set_points = CommandStreams(self._commands)
        for package in PACKAGES:
            for space, services in self._services().items():
                for name, handle in services.items():
                    camel = "".join(part.capitalize() for part in name.split("_"))
                    kind = f"{package}/{_TYPES.get(name, camel)}"
                    served = name.replace("ctrl_box_", "") if package == _OF_ROS1 else name
                    self._offer(f"{space}/{served}", kind, handle)
        self._streams: Mapping[str, Callable[[Any], JointTrajectory | None]] = {
            f"{package}/{kind}": take
            for package in PACKAGES
            for kind, take in (
                ("ServojStream", self._servo_joints),
                ("ServolStream", self._servo_line),
                ("SpeedjStream", self._speed_joints),
                ("SpeedlStream", self._speed_line),
            )
        }
        self._graph.watch(self._on_change)

    def _services(self) -> Mapping[str, Mapping[str, Handler]]:
        services = {**super()._services()}
        services["motion"] = {
            **services["motion"],
            "move_joint": self._moving("movej", self._joint),
            "move_jointx": self._moving("movejx", self._jointx),
            "move_line": self._moving("movel", self._line),
            "move_circle": self._moving("movec", self._circle),
            "move_spline_joint": self._moving("movesj", self._spline_joint),
            "move_spline_task": self._moving("movesx", self._spline_task),
            "move_blending": self._moving("moveb", self._blending),
            "move_spiral": self._moving("move_spiral", self._spiral),
            "move_periodic": self._moving("move_periodic", self._periodic),
            "move_home": self._home,
            "move_wait": self._wait,
            "move_stop": self._stop,
            "jog": self._jog,
        }
        services["gripper"] = {
            "robotiq_2f_open": lambda asked, _: self._grip(1.0),
            "robotiq_2f_close": lambda asked, _: self._grip(0.0),
        }
        return services

    # Motions

    def _moving(self, kind: str, make: Callable[[Any], JointTrajectory]) -> Handler:
        def move(request: Any, answer: Any) -> bool:
            stack = self._commands.stack()
            self._wait(request, answer)
            try:
                motion = self._arm.start(f"doosan_{kind}", make(request), stack, what=kind)
            except PlanningError as error:
                self._report(kind, error.message, stack)
                return False
            self._live = motion
            if _field(request, "sync_type"):
                return True
            self._wait(request, answer)
            return motion.outcome == "succeeded"

        return move

    def _report(self, kind: str, message: str, stack: tuple[Frame, ...] | None = None) -> None:
        self._commands.report("command_ignored", f"{kind} moved nothing: {message}", stack)

    def _joint(self, asked: Any) -> JointTrajectory:
        each = [1.0] * len(self._arm.joints)
        speeds, rises = [asked.vel * one for one in each], [asked.acc * one for one in each]
        if not asked.mode:
            self._arm.look_at_degrees("move_joint", list(asked.pos))
        return self._motion.joint_move(list(asked.pos), asked.mode, speeds, rises, asked.time)

    def _jointx(self, asked: Any) -> JointTrajectory:
        goal = self._motion.to_joints_of(self._motion.pose(asked.pos, asked.ref, asked.mode))
        each = [1.0] * len(self._arm.joints)
        speeds, rises = [asked.vel * one for one in each], [asked.acc * one for one in each]
        return self._motion.joint_move(goal, 0, speeds, rises, asked.time)

    def _line(self, asked: Any) -> JointTrajectory:
        pose = self._motion.pose(asked.pos, asked.ref, asked.mode)
        return self._motion.line([pose], list(asked.vel), asked.time)

    def _circle(self, asked: Any) -> JointTrajectory:
        if len(asked.pos) != 2:
            raise PlanningError("bad_request", f"{len(asked.pos)} poses; a circle has 2")
        if asked.angle1 or asked.angle2:
            raise PlanningError("bad_request", "angles of a circle are not simulated")
        via, end = self._path(asked.pos, asked.ref, asked.mode)
        return self._motion.line(self._motion.arc(via, end), list(asked.vel), asked.time)

    def _spline_joint(self, asked: Any) -> JointTrajectory:
        points = [list(item.data)[: len(self._arm.joints)] for item in asked.pos]
        speeds, rises = list(asked.vel), list(asked.acc)
        return self._motion.spline(points, asked.mode, speeds, rises, asked.time)

    def _spline_task(self, asked: Any) -> JointTrajectory:
        poses = self._path(asked.pos, asked.ref, asked.mode)
        return self._motion.line(poses, list(asked.vel), asked.time)

    def _blending(self, asked: Any) -> JointTrajectory:
        poses: list[Pose] = []
        for segment in asked.segment:
            values = list(segment.data)
            before = poses[-1] if poses else None
            first = self._motion.pose(values[:6], asked.ref, asked.mode, before)
            if len(values) > 12 and round(values[12]) == _CIRCLE:
                end = self._motion.pose(values[6:12], asked.ref, asked.mode, first)
                poses.extend(self._motion.arc(first, end, before))
            else:
                poses.append(first)
        return self._motion.line(poses, list(asked.vel), asked.time)

    def _spiral(self, asked: Any) -> JointTrajectory:
        poses = self._motion.spiral(
            float(_field(asked, "revolution")),
            _field(asked, "max_radius") / 1000,
            _field(asked, "max_length") / 1000,
            _field(asked, "task_axis"),
            asked.ref,
        )
        return self._motion.line(poses, list(asked.vel), asked.time)

    def _periodic(self, asked: Any) -> JointTrajectory:
        return self._motion.periodic(list(asked.amp), list(asked.periodic), asked.repeat, asked.ref)

    def _path(self, given: Sequence[Any], ref: int, mode: int) -> list[Pose]:
        poses: list[Pose] = []
        for item in given:
            before = poses[-1] if poses else None
            poses.append(self._motion.pose(list(item.data), ref, mode, before))
        return poses

    def _home(self, request: Any, answer: Any) -> bool:
        stack = self._commands.stack()
        self._wait(request, answer)
        motion = self._arm.start("doosan_home", self._arm.to_joints([0.0] * _AXES), stack)
        self._live = motion
        return self._arm.wait(motion)

    def _wait(self, request: Any, answer: Any) -> None:
        if self._live is not None:
            self._arm.wait(self._live)

    def _stop(self, request: Any, answer: Any) -> None:
        self._commands.stop_came("move_stop")
        self._arm.stop()

    def _jog(self, request: Any, answer: Any) -> bool:
        stack, axis = self._commands.stack(), request.jog_axis
        share = request.speed / 100.0
        if not 0 <= axis < 2 * _AXES:
            self._report("jog", f"axis {axis}; allowed: 0 to 11", stack)
            return False
        if abs(share) < 1e-6:
            self._arm.stop()
            return True
        try:
            if axis < _AXES:
                speeds = [0.0] * _AXES
                speeds[axis] = share * self._arm.arm[axis].velocity_limit
                trajectory = self._arm.at_speeds(speeds)
            else:
                parts = [0.0] * _AXES
                # 250 mm/s, the most that a manual mode allows (ISO 10218-1), and 30 deg/s: assumed.
                parts[axis - _AXES] = share * (0.25 if axis < _AXES + 3 else math.radians(30))
                trajectory = self._twist(parts, request.move_reference)
        except PlanningError as error:
            self._report("jog", error.message, stack)
            return False
        if trajectory is None:
            self._report("jog", "the joint is at its limit", stack)
            return False
        self._live = self._arm.start("doosan_jog", trajectory, stack)
        return True

    def _twist(self, parts: Sequence[float], ref: int = 0) -> JointTrajectory | None:
        return self._arm.twist(parts[:3], parts[3:], "tool" if ref == 1 else "base")

    def _grip(self, opened: float) -> bool:
        stack = self._commands.stack()
        try:
            self._arm.move_gripper(opened, stack)
        except PlanningError as error:
            self._report("gripper", error.message, stack)
            return False
        return True

    # Streams

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "advertised" and type_name in self._streams:
            self._hear(name, type_name, partial(self._take, self._streams[type_name]))

    def _take(
        self,
        make: Callable[[Any], JointTrajectory | None],
        message: Any,
        publication: Publication,
    ) -> None:
        try:
            trajectory = make(message)
        except PlanningError as error:
            self._report(publication.topic, error.message)
            return
        topic, kind, due_s = (
            publication.topic,
            "doosan_stream",
            float(getattr(message, "time", 0.0)),
        )
        if trajectory is None:
            self._arm.stop()
        elif trajectory.leads == "to_goal" and 0.0 < due_s <= SHORT_S:
            joints, goal = trajectory.joints, trajectory.position[-1]
            self._set_points.to_position(topic, kind, joints, goal, due_s=due_s)
        else:
            self._set_points.follow(topic, kind, trajectory, is_set_point=True)

    def _servo_joints(self, asked: Any) -> JointTrajectory:
        speeds, rises = list(asked.vel), list(asked.acc)
        return self._motion.joint_move(list(asked.pos), 0, speeds, rises, asked.time)

    def _servo_line(self, asked: Any) -> JointTrajectory:
        return self._motion.line([pose_of(asked.pos)], list(asked.vel), asked.time)

    def _speed_joints(self, asked: Any) -> JointTrajectory | None:
        self._arm.look_at_degrees_per_s("speedj_stream", list(asked.vel))
        return self._arm.at_speeds([math.radians(item) for item in asked.vel], asked.time or None)

    def _speed_line(self, asked: Any) -> JointTrajectory | None:
        values = list(asked.vel)
        parts = [value / 1000 for value in values[:3]] + [
            math.radians(value) for value in values[3:]
        ]
        return self._twist(parts)


def _field(message: Any, name: str) -> Any:
    """Return a field of ROS 2, or as ROS 1 writes it: `sync_type` is `syncType` there."""
    if hasattr(message, name):
        return getattr(message, name)
    first, *rest = name.split("_")
    return getattr(message, first + "".join(part.capitalize() for part in rest))
