"""The nodes of a Niryo arm on the graph: commander, tools, joints, poses and pins.

Source of names and behaviour: NiryoRobotics/ned_ros; the names are fixed there. Timeouts of the
Python wrapper are assumed.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.transforms.poses import quaternion_from_rpy, rpy_from_quaternion
from tracerisk.ros.vendors.niryo.actions import STATUS_OF, NiryoActions
from tracerisk.ros.vendors.niryo.places import Handler, filled
from tracerisk.twin.physics.motion import PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.common.traced.elements import SensorKind
    from tracerisk.ros.graph.runtime import Runtime

_MESSAGES = "niryo_robot_msgs"
_STATE = f"{_MESSAGES}/RobotState"  # the pose of the tool
_HZ = 10.0
_SUCCESS, _NOT_IMPLEMENTED, _INVALID = 1, -51, -52
_DONE = _SUCCESS, "Success"
_PIN_ERROR, _NO_INVERSE, _NO_FORWARD = -114, -232, -233
_GRIPPER_1 = 11


class NiryoRobot(NiryoActions):
    """Answers as the nodes of a Niryo arm."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._is_learning = False
        self._home: list[float] | None = None
        self._pins: dict[str, float] = {}
        if not messages.has("service", f"{_MESSAGES}/Trigger"):
            return
        for space, services in self._services().items():
            for name, (kind, handle) in services.items():
                self._offer(f"{space}/{name}", kind, handle)
        self._offer_parameters(_MESSAGES, self._parameters())
        self._topics: Mapping[str, tuple[str, Callable[[Any], Any]]] = {
            "/niryo_robot/robot_state": (_STATE, self._state),
            "/niryo_robot/learning_mode/state": (
                "std_msgs/Bool",
                lambda message: _with(message, data=self._is_learning),
            ),
            "/niryo_robot/max_velocity_scaling_factor": (
                "std_msgs/Int32",
                lambda message: _with(message, data=round(100 * self._motion.velocity)),
            ),
            "/niryo_robot_hardware_interface/hardware_status": (
                f"{_MESSAGES}/HardwareStatus",
                self._hardware,
            ),
            "/niryo_robot_tools_commander/current_id": (
                "std_msgs/Int32",
                lambda message: _with(message, data=self._tool_id),
            ),
            "/niryo_robot_tools_commander/tcp": ("niryo_robot_tools_commander/TCP", self._tcp),
            "/niryo_robot_poses_handlers/pose_list": (
                f"{_MESSAGES}/BasicObjectArray",
                lambda message: self._listed(self._poses, message),
            ),
            "/niryo_robot_poses_handlers/dynamic_frame_list": (
                f"{_MESSAGES}/BasicObjectArray",
                lambda message: self._listed(self._frames, message),
            ),
        }
        self._graph.watch(self._on_change)

    def _services(self) -> Mapping[str, Mapping[str, tuple[str, Handler]]]:
        trigger, flag, number = (f"{_MESSAGES}/{kind}" for kind in ("Trigger", "SetBool", "SetInt"))
        commander = "niryo_robot_arm_commander"
        pins = "niryo_robot_rpi"
        return {
            "niryo_robot_status": {"ping_ros_wrapper": (f"{_MESSAGES}/Ping", _nothing)},
            "joints_interface": {
                "request_new_calibration": (trigger, _nothing),
                "calibrate_motors": (number, _nothing),
            },
            "learning_mode": {"activate": (flag, self._learn)},
            commander: {
                "set_max_velocity_scaling_factor": (number, partial(self._scale, "velocity")),
                "set_acceleration_factor": (number, partial(self._scale, "acceleration")),
                "stop_command": (trigger, self._stop),
                "compute_waypointed_trajectory": (f"{commander}/ComputeTrajectory", self._refuse),
                "manage_trajectory": (f"{commander}/ManageTrajectory", self._refuse),
            },
            "niryo_robot_joints_interface": {
                "get_home_position": (f"{_MESSAGES}/GetFloatList", self._get_home),
                "set_home_position": (f"{_MESSAGES}/SetFloatList", self._set_home),
                "reset_home_position": (trigger, self._reset_home),
            },
            "jog_interface": {
                "enable": (flag, _nothing),
                "jog_shift_commander": (f"{commander}/JogShift", self._jog),
            },
            "kinematics": {
                "forward": (f"{commander}/GetFK", self._forward),
                "inverse": (f"{commander}/GetIK", self._inverse),
            },
            "niryo_robot_tools_commander": {
                "update_tool": (trigger, _nothing),
                "enable_tcp": (flag, self._enable_tcp),
                "set_tcp": ("niryo_robot_tools_commander/SetTCP", self._set_tcp),
                "reset_tcp": (trigger, self._reset_tcp),
            },
            "tools": {"reboot": (trigger, _nothing)},
            "niryo_robot_hardware_interface": {"reboot_motors": (trigger, _nothing)},
            "niryo_robot_poses_handlers": self._services_of_places(),
            pins: {
                "set_digital_io_mode": (f"{pins}/SetIOMode", _nothing),
                "set_digital_io": (f"{pins}/SetDigitalIO", self._set_pin),
                "set_analog_io": (f"{pins}/SetAnalogIO", self._set_pin),
                "get_digital_io": (f"{pins}/GetDigitalIO", self._get_pin),
                "get_analog_io": (f"{pins}/GetAnalogIO", self._get_pin),
            },
            "niryo_robot_led_ring": {
                "set_user_animation": ("niryo_robot_led_ring/LedUser", self._shown),
                "set_led_color": ("niryo_robot_led_ring/SetLedColor", self._shown),
            },
            "niryo_robot_sound": {
                "play": ("niryo_robot_sound/PlaySound", self._shown),
                "set_volume": (number, self._shown),
                "stop": (trigger, self._shown),
            },
        }

    def _parameters(self) -> Mapping[str, Any]:
        wrapper = "/niryo_robot/python_ros_wrapper"
        name = self._arm.twin.robot.name
        known = next(
            (literal for literal in ("ned3pro", "ned2", "ned", "one") if literal in name), "ned2"
        )
        nodes = ("poses_handlers", "arm_commander", "rpi", "tools_commander")
        controllers = self._arm.twin.robot.controllers
        follow = next((c.name for c in controllers if c.type == "follow_joint_trajectory"), "")
        return {
            f"{wrapper}/service_timeout": 2,
            f"{wrapper}/action_connection_timeout": 20,
            f"{wrapper}/action_execute_timeout": 3600,
            f"{wrapper}/action_preempt_timeout": 10,
            "/niryo_robot/simulation_mode": True,
            "/niryo_robot/hardware_version": known,
            "/niryo_robot_arm_commander/joint_controller_name": f"/{follow or 'controller'}",
            **{f"/niryo_robot_{node}/initialized": True for node in nodes},
        }

    def _conclude(self, answer: Any, result: Any) -> None:
        for name, value in zip(("status", "message"), result or _DONE, strict=True):
            if name in answer.__slots__:
                setattr(answer, name, value)

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        kind, make = self._topics.get(name, ("", None))
        if change == "subscribed" and kind == type_name and make is not None:
            sensors: tuple[SensorKind, ...] = ("encoder",) if kind == _STATE else ()
            self._report_on(name, kind, _HZ, lambda message, _: make(message), sensors)

    def _next_ns(self, period_ns: int, *, is_first: bool) -> int:
        return self._scheduler.now_ns + (1_000_000 if is_first else period_ns)

    def _state(self, message: Any) -> Any:
        return filled(message, self._motion.here())

    def _hardware(self, message: Any) -> Any:
        message.hardware_version = str(self._parameters()["/niryo_robot/hardware_version"])
        message.connection_up = True
        message.motor_names = list(self._arm.joints)
        return message

    def _tcp(self, message: Any) -> Any:
        message.enabled = self._motion.is_tcp_on
        return filled(message, self._motion.tcp)

    @property
    def _tool_id(self) -> int:
        return _GRIPPER_1 if self._arm.gripper is not None else 0

    # Services

    def _learn(self, request: Any, answer: Any) -> None:
        self._is_learning = bool(request.value)

    def _scale(self, kind: str, request: Any, answer: Any) -> tuple[int, str]:
        if request.value < 1:
            return _INVALID, f"{kind} scaling factor {request.value} %; give 1 or more"
        setattr(self._motion, kind, min(request.value, 100) / 100.0)
        return _DONE

    def _stop(self, request: Any, answer: Any) -> tuple[int, str]:
        self._stop_goal()
        return _SUCCESS, "Command stopped"

    def _get_home(self, request: Any, answer: Any) -> None:
        home = self._home
        if home is None:
            states = self._arm.twin.robot.named_states.get(self._arm.group or "", {})
            resting = states.get("resting", {})
            home = [resting.get(name, 0.0) for name in self._arm.joints]
        answer.values = home

    def _set_home(self, request: Any, answer: Any) -> tuple[int, str]:
        try:
            self._arm.check(list(request.values))
        except PlanningError as error:
            return _INVALID, error.message
        self._home = list(request.values)
        return _DONE

    def _reset_home(self, request: Any, answer: Any) -> None:
        self._home = None

    def _jog(self, request: Any, answer: Any) -> tuple[int, str]:
        stack, values = self._commands.stack(), list(request.shift_values)
        try:
            if request.cmd == 1:
                here = self._arm.positions()
                goal = [a + b for a, b in zip(here, values, strict=False)]
            elif len(values) == 6:
                pose = self._motion.here()
                rpy = rpy_from_quaternion(pose.orientation)
                x, y, z = (a + b for a, b in zip(pose.position, values[:3], strict=True))
                turned = [a + b for a, b in zip(rpy, values[3:], strict=True)]
                goal = self._motion.to_joints_of(Pose((x, y, z), quaternion_from_rpy(*turned)))
            else:
                raise PlanningError("invalid_goal", f"{len(values)} shift values, 6 expected")
            self._arm.start("niryo_jog", self._arm.to_joints(goal), stack)
        except PlanningError as error:
            self._commands.report("command_ignored", f"jog moved nothing: {error.message}", stack)
            return STATUS_OF[error.failure], error.message
        return _DONE

    def _forward(self, request: Any, answer: Any) -> tuple[int, str]:
        try:
            self._arm.check(list(request.joints))
        except PlanningError as error:
            return _NO_FORWARD, error.message
        filled(answer.pose, self._motion.of_joints(list(request.joints)))
        return _DONE

    def _inverse(self, request: Any, answer: Any) -> tuple[int, str]:
        at, rpy = request.pose.position, request.pose.rpy
        turned = quaternion_from_rpy(rpy.roll, rpy.pitch, rpy.yaw)
        try:
            answer.joints = self._motion.to_joints_of(Pose((at.x, at.y, at.z), turned))
        except PlanningError as error:
            return _NO_INVERSE, error.message
        return _DONE

    def _enable_tcp(self, request: Any, answer: Any) -> None:
        self._motion.is_tcp_on = bool(request.value)

    def _set_tcp(self, request: Any, answer: Any) -> None:
        at, rpy = request.position, request.rpy
        turned = quaternion_from_rpy(rpy.roll, rpy.pitch, rpy.yaw)
        self._motion.tcp, self._motion.is_tcp_on = Pose((at.x, at.y, at.z), turned), True

    def _reset_tcp(self, request: Any, answer: Any) -> None:
        self._motion.tcp = self._motion.tcp_of_tool()

    def _set_pin(self, request: Any, answer: Any) -> None:
        self._pins[request.name] = float(request.value)

    def _get_pin(self, request: Any, answer: Any) -> tuple[int, str]:
        if not request.name:
            return _PIN_ERROR, "give the name of a pin"
        answer.value = type(answer.value)(self._pins.get(request.name, 0.0))
        return _DONE

    def _shown(self, request: Any, answer: Any) -> None:
        self._commands.report("not_simulated", "lights and sounds change nothing on the twin")

    def _refuse(self, request: Any, answer: Any) -> tuple[int, str]:
        message = "stored and computed trajectories are not simulated: nothing moved"
        self._commands.report("not_simulated", message)
        return _NOT_IMPLEMENTED, message


def _nothing(request: Any, answer: Any) -> None:
    """Answer what asks for nothing that the twin lacks: it is calibrated, and always on."""


def _with(message: Any, **values: Any) -> Any:
    for name, value in values.items():
        setattr(message, name, value)
    return message
