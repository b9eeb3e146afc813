"""The driver of an xArm or a Lite 6 on the graph: the services of xarm_api, of either ROS.

Source: xArm-Developer/xarm_ros (xarm_api, readme) and xarm_ros2 (xarm_driver_service.cpp).
"""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph import Change, Publication
from tracerisk.ros.sensor_reading import SensorReading
from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_grippers import gripper_ends
from tracerisk.ros.twin_messages import TwinMessages
from tracerisk.twin.motion import PlanningError
from tracerisk.vendors.ufactory.motion import (
    READY,
    STOPPED,
    PoseError,
    Waiting,
    XarmMotion,
    pose_of,
)

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

_PACKAGE = "xarm_msgs"
_NODE = "/ufactory_driver"
_HZ = 5.0  # of RobotMsg in the normal report
_MOST_PULSES = 850.0  # of the gripper, wide open


class XarmDriver:
    """Answers as the driver of the twin's arm; motions go into the queue of the controller box."""

    def __init__(self, runtime: Runtime, messages: TwinMessages, commands: TwinCommands) -> None:
        self._graph, self._scheduler = runtime.graph, runtime.scheduler
        self._reading = runtime.client(SensorReading)
        self._messages = messages
        self._commands = commands
        self._twin = commands.twin
        self._gripper = next(iter(self._twin.robot.grippers), None)
        self._motion = XarmMotion(commands)
        self._publications: set[str] = set()
        for name, kind, handle in self._services():
            full = f"{_PACKAGE}/{kind}"
            if messages.has_service(full):
                self._graph.offer(name, full, self._answering(full, handle), node=_NODE)
        self._graph.watch(self._on_change)

    def _services(self) -> Sequence[tuple[str, str, Callable[[Any, Any], int]]]:
        return (
            # ROS 2
            ("motion_enable", "SetInt16ById", self._enable),
            ("set_mode", "SetInt16", lambda asked, _: self._set_mode(asked.data)),
            ("set_state", "SetInt16", lambda asked, _: self._set_state(asked.data)),
            ("clean_error", "Call", self._clean),
            ("clean_warn", "Call", lambda asked, answer: 0),
            ("set_servo_angle", "MoveJoint", self._move_joint),
            ("set_servo_angle_j", "MoveJoint", self._move_joint),
            ("set_position", "MoveCartesian", self._move_line),
            ("set_tool_position", "MoveCartesian", self._move_tool),
            ("move_gohome", "MoveHome", self._go_home),
            ("vc_set_joint_velocity", "MoveVelocity", self._at_speeds),
            ("get_servo_angle", "GetFloat32List", self._get_angles),
            ("get_position", "GetFloat32List", self._get_position),
            ("get_state", "GetInt16", self._get_state),
            ("get_cmdnum", "GetInt16", self._get_count),
            ("get_err_warn_code", "GetInt16List", self._get_errors),
            ("set_gripper_enable", "SetInt16", self._has_gripper),
            ("set_gripper_mode", "SetInt16", self._has_gripper),
            ("set_gripper_speed", "SetFloat32", self._has_gripper),
            ("set_gripper_position", "GripperMove", self._move_gripper),
            ("get_gripper_position", "GetFloat32", self._get_gripper),
            ("get_gripper_err_code", "GetInt16", self._has_gripper),
            ("clean_gripper_error", "Call", self._has_gripper),
            ("open_lite6_gripper", "Call", lambda asked, _: self._grip(_MOST_PULSES)),
            ("close_lite6_gripper", "Call", lambda asked, _: self._grip(0.0)),
            ("stop_lite6_gripper", "Call", self._has_gripper),
            # ROS 1, where these differ
            ("motion_ctrl", "SetAxis", self._enable),
            ("move_joint", "Move", self._move_joint1),
            ("move_jointb", "Move", self._move_joint1),
            ("move_servoj", "Move", self._move_joint1),
            ("move_line", "Move", self._move_line1),
            ("move_lineb", "Move", self._move_line1),
            ("move_line_tool", "Move", self._move_tool1),
            ("go_home", "Move", self._go_home),
            ("velo_move_joint", "MoveVelo", self._at_velocities1),
            ("velo_move_joint_timed", "MoveVelocity", self._at_speeds),
            ("get_position_rpy", "GetFloat32List", self._get_position),
            ("clear_err", "ClearErr", self._clean),
            ("moveit_clear_err", "ClearErr", self._clean),
            ("get_err", "GetErr", self._get_error1),
            ("gripper_config", "GripperConfig", self._has_gripper),
            ("gripper_move", "GripperMove", self._move_gripper1),
            ("gripper_state", "GripperState", self._get_gripper1),
        )

    def _answering(self, kind: str, handle: Callable[[Any, Any], int]) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            response = self._messages.response(kind)
            try:
                response.ret = handle(request, response)
            except PoseError as error:
                response.ret, response.message = -1, str(error)
            if not response.message:
                response.message = f"ret={response.ret}"
            return response

        return answer

    # Reports

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change != "subscribed" or type_name != f"{_PACKAGE}/RobotMsg":
            return
        if name not in self._publications:
            self._publications.add(name)
            publication = self._graph.advertise(name, type_name, node=_NODE, by_controller=False)
            self._reading.tells_joints(publication, _HZ)
            self._schedule(publication)

    def _schedule(self, publication: Publication) -> None:
        period_ns = round(1e9 / _HZ)
        due_ns = (self._scheduler.now_ns // period_ns + 1) * period_ns
        self._scheduler.call_at(due_ns, lambda: self._report(publication), background=True)

    def _report(self, publication: Publication) -> None:
        if not publication.subscriptions:
            self._publications.discard(publication.topic)
            publication.close()
            return
        motion = self._motion
        message = self._messages.new(f"{_PACKAGE}/RobotMsg")
        self._messages.stamp(message.header, self._scheduler.now_ns)
        message.state, message.mode, message.err = self._state(), motion.mode, motion.error
        message.mt_brake = message.mt_able = (1 << len(motion.joints)) - 1
        message.angle, message.pose = motion.positions(), motion.flange_pose()
        publication.publish(message)
        self._schedule(publication)

    # Modes and states

    def _enable(self, request: Any, answer: Any) -> int:
        if not request.data:
            self._motion.stop()
            self._motion.state = STOPPED
        return 0

    def _set_mode(self, mode: int) -> int:
        self._motion.stop()
        self._motion.mode = mode
        return 0

    def _set_state(self, state: int) -> int:
        if state == STOPPED:
            self._motion.stop()
        self._motion.state = STOPPED if state == STOPPED or self._motion.error else READY
        return 0

    def _state(self) -> int:
        return 1 if self._motion.is_busy else self._motion.state

    def _clean(self, request: Any, answer: Any) -> int:
        self._motion.error = 0
        return 0

    def _get_state(self, request: Any, answer: Any) -> int:
        self._scheduler.touch()
        answer.data = self._state()
        return 0

    def _get_count(self, request: Any, answer: Any) -> int:
        self._scheduler.touch()
        answer.data = int(self._motion.is_busy)
        return 0

    def _get_errors(self, request: Any, answer: Any) -> int:
        answer.datas = [self._motion.error, 0]
        return 0

    def _get_error1(self, request: Any, answer: Any) -> int:
        answer.err = self._motion.error
        return 0

    def _get_angles(self, request: Any, answer: Any) -> int:
        self._scheduler.touch()
        self._reading.asked("encoder")
        answer.datas = self._motion.positions()
        return 0

    def _get_position(self, request: Any, answer: Any) -> int:
        self._scheduler.touch()
        self._reading.asked("encoder")
        answer.datas = self._motion.flange_pose()
        return 0

    # Motions

    def _ask(self, waiting: Waiting, *, wait: bool, timeout_s: float = -1.0) -> int:
        code = self._motion.ask(waiting)
        if code or not wait:
            return code
        self._scheduler.wait_until(
            lambda: not self._motion.is_busy,
            timeout_ns=round(timeout_s * 1e9) if timeout_s >= 0 else None,
            reason="the arm to finish",
        )
        return self._motion.refused()

    def _move_joint(self, request: Any, answer: Any) -> int:
        goal = [float(angle) for angle in request.angles]
        if request.relative:
            goal = [a + b for a, b in zip(goal, self._motion.positions(), strict=False)]
        return self._ask(
            self._to_joints(goal, request.speed, request.acc),
            wait=request.wait,
            timeout_s=request.timeout,
        )

    def _move_joint1(self, request: Any, answer: Any) -> int:
        goal = [float(angle) for angle in request.pose]
        waiting = self._to_joints(goal, request.mvvelo, request.mvacc)
        return self._ask(waiting, wait=self._waits())

    def _to_joints(self, goal: Sequence[float], speed: float, acceleration: float) -> Waiting:
        stack = self._commands.stack()
        return Waiting("xarm_move_joint", stack, tuple(goal), None, speed, acceleration)

    def _go_home(self, request: Any, answer: Any) -> int:
        is_ros2 = hasattr(request, "speed")
        goal = [0.0] * len(self._motion.joints)
        speed = request.speed if is_ros2 else request.mvvelo
        rise = request.acc if is_ros2 else request.mvacc
        waiting = self._to_joints(goal, speed, rise)
        return self._ask(waiting, wait=request.wait if is_ros2 else self._waits())

    def _move_line(self, request: Any, answer: Any) -> int:
        pose = pose_of(request.pose)
        if request.is_tool_coord or request.relative:
            pose = self._motion.relative(pose, in_tool=request.is_tool_coord)
        return self._to_pose(pose, request.speed, request.wait, request.timeout)

    def _move_tool(self, request: Any, answer: Any) -> int:
        pose = self._motion.relative(pose_of(request.pose), in_tool=True)
        return self._to_pose(pose, request.speed, request.wait, request.timeout)

    def _move_line1(self, request: Any, answer: Any) -> int:
        return self._to_pose(pose_of(request.pose), request.mvvelo, self._waits(), -1.0)

    def _move_tool1(self, request: Any, answer: Any) -> int:
        pose = self._motion.relative(pose_of(request.pose), in_tool=True)
        return self._to_pose(pose, request.mvvelo, self._waits(), -1.0)

    def _to_pose(self, pose: Any, speed: float, wait: bool, timeout_s: float) -> int:
        waiting = Waiting("xarm_move_line", self._commands.stack(), None, pose, speed)
        return self._ask(waiting, wait=wait, timeout_s=timeout_s)

    def _waits(self) -> bool:
        # xarm_ros: the parameter of the driver's namespace, off by default.
        names = (name for name in self._graph.parameters.names() if "wait_for_finish" in name)
        return any(bool(self._graph.parameters.get(name)) for name in names)

    def _at_speeds(self, request: Any, answer: Any) -> int:
        duration = request.duration if request.duration > 0 else None
        return self._motion.at_speeds(list(request.speeds), duration, "xarm_velocity")

    def _at_velocities1(self, request: Any, answer: Any) -> int:
        return self._motion.at_speeds(list(request.velocities), None, "xarm_velocity")

    # The gripper

    def _has_gripper(self, request: Any, answer: Any) -> int:
        return 0 if self._gripper is not None else self._no_gripper()

    def _no_gripper(self) -> int:
        self._commands.tell(
            "not_simulated",
            f"robot '{self._twin.robot.name}' has no gripper with joints: none moved",
            self._commands.stack(),
        )
        return 0

    def _grip(self, pulses: float, *, wait: bool = False, timeout_s: float = 10.0) -> int:
        gripper, stack = self._gripper, self._commands.stack()
        if gripper is None:
            return self._no_gripper()
        closed, opened = gripper_ends(self._twin.robot, gripper)
        part = min(max(pulses, 0.0), _MOST_PULSES) / _MOST_PULSES
        goal = min(max(closed + part * (opened - closed), gripper.least), gripper.opening)
        try:
            motion = self._twin.move_gripper(gripper.name, goal)
        except PlanningError as error:
            self._commands.tell("command_ignored", error.message, stack)
            return -1
        self._commands.begin("gripper_command", motion, stack)
        if wait:
            self._scheduler.wait_until(
                lambda: motion.outcome != "active",
                timeout_ns=round(timeout_s * 1e9),
                reason="the gripper to finish",
            )
        return 0

    def _move_gripper(self, request: Any, answer: Any) -> int:
        return self._grip(request.pos, wait=request.wait, timeout_s=request.timeout)

    def _move_gripper1(self, request: Any, answer: Any) -> int:
        return self._grip(request.pulse_pos, wait=self._waits())

    def _pulses(self) -> float:
        gripper = self._gripper
        if gripper is None:
            return 0.0
        self._scheduler.touch()
        state = self._twin.joint_state()
        at = dict(zip(state.names, state.position, strict=True))
        closed, opened = gripper_ends(self._twin.robot, gripper)
        return _MOST_PULSES * (gripper.position(at) - closed) / (opened - closed)

    def _get_gripper(self, request: Any, answer: Any) -> int:
        answer.data = self._pulses()
        return 0

    def _get_gripper1(self, request: Any, answer: Any) -> int:
        answer.curr_pos = self._pulses()
        return 0
