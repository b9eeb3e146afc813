"""moveit_servo: velocities of the tool, or of joints, that come as a stream of messages.

Units, scales and the time after which an arm without messages rests are those that a parameter file
of the workspace gives servo, else those that it has by default (`servo_parameters.yaml` of MoveIt
2). Near a singularity the tool slows down as there, by the condition number of the Jacobian.
Servo's slowing down near obstacles is not simulated, nor are goals of poses.

It begins to take commands as `servo-start` of the distributions says, or, as the run assumes, by a
user's hand where no program starts it. It takes none that are older than its time-out, or have no
stamp: `servo_calcs.cpp` (Humble) and `servo_node.cpp` (Jazzy) of moveit/moveit2, `servo_calcs.cpp`
of moveit/moveit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.declared_controllers import declared_settings
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.bring_up.launched import LaunchedControllers
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.ros.transforms.poses import rotate

if TYPE_CHECKING:
    from tracerisk.ros.graph.graph import Change
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.robot.messages import TwinMessages

TWIST = "geometry_msgs/TwistStamped"
JOG = "control_msgs/JointJog"
POSE = "geometry_msgs/PoseStamped"
_STATUS = {"std_msgs/Int8": "data", "moveit_msgs/ServoStatus": "code"}
_STATUS_HZ = 10.0
_OF = "moveit_msgs/"
_UNITLESS = "unitless"
_AHEAD = 0.01  # where it is seen whether a singularity nears [rad or m]
_DIMENSIONS = 6
_SLOW = 0.1  # of its speed: less is reported
_JOINT_JOG, _TWIST, _POSE_GOAL = 0, 1, 2  # as moveit_msgs/ServoCommandType numbers them
_BEGINS = "servo-start"
_BY_ITSELF = "from the beginning"
_BY_CALL, _BY_TYPE = "after start_servo", "after switch_command_type"
_OF_STATE = ("start_servo", "stop_servo", "pause_servo", "unpause_servo", "switch_command_type")
_NO_WARNING, _APPROACHING, _HALTED, _LEAVING = 0, 1, 2, 3  # as moveit_msgs/ServoStatus
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """What a parameter file gives servo; the defaults are those of MoveIt 2."""

    command_in_type: str = _UNITLESS
    """`unitless`: shares of the scales, as from a joystick; `speed_units`: m/s and rad/s."""
    linear: float = 0.4
    """The speed of the tool at a share of 1 [m/s]."""
    rotational: float = 0.8
    """The rate of turn of the tool at a share of 1 [rad/s]."""
    joint: float = 0.5
    """The velocity of a joint at a share of 1 [rad/s or m/s]."""
    incoming_command_timeout: float = 0.1
    """How long the arm goes on after a message [s]."""
    lower_singularity_threshold: float = 17.0
    """The condition number from which the tool slows down."""
    hard_stop_singularity_threshold: float = 30.0
    """The condition number at which it stops."""
    cartesian_command_in_topic: str = "delta_twist_cmds"
    """The last name of the topic of twists."""
    joint_command_in_topic: str = "delta_joint_cmds"
    """The last name of the topic of velocities of joints."""
    move_group_name: str = ""
    """The group that moves; empty for the robot's largest."""
    is_declared: bool = False
    """Whether a file of the workspace gives them."""


class Servo(TwinNode):
    """Follows the streams of messages that a controller sends to moveit_servo.

    A topic that the controller itself subscribes to is its own affair, and moves nothing.
    """

    node = "/servo_node"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._streams = CommandStreams(self._commands)
        self._is_started = self._is_paused = False
        self._expected: int | None = None
        self._assumed = ""
        self._controlled = np.ones(6)
        self._status = _NO_WARNING
        of_humble, of_jazzy = self._has(_BY_CALL), self._has(_BY_TYPE)
        of_older = of_humble or self._has(_BY_ITSELF)
        trigger = "std_srvs/Trigger"
        for name, kind, handle, is_there in (
            ("start_servo", trigger, lambda *_: self._start(), of_humble),
            ("unpause_servo", trigger, lambda *_: self._pause(False), of_humble),
            ("stop_servo", trigger, lambda *_: self._pause(True), of_humble),
            ("pause_servo", trigger, lambda *_: self._pause(True), of_humble),
            ("pause_servo", "std_srvs/SetBool", self._set_pause, of_jazzy),
            ("switch_command_type", f"{_OF}ServoCommandType", self._switch, of_jazzy),
            ("change_control_dimensions", f"{_OF}ChangeControlDimensions", self._control, of_older),
            ("change_drift_dimensions", f"{_OF}ChangeDriftDimensions", self._drift, of_older),
            ("reset_servo_status", "std_srvs/Empty", lambda *_: None, of_older),
        ):
            if is_there:
                self._offer(name, kind, handle)
        self._graph.watch(self._on_change)

    def _has(self, start: str) -> bool:
        """Whether servo may be one that begins so: nobody knows it of an assumed distribution."""
        rules = self._runtime.distro
        return rules.is_assumed or rules.value(_BEGINS) == start

    def _conclude(self, answer: Any, result: Any) -> None:
        if result is not None:
            answer.success = result

    @cached_property
    def settings(self) -> ServoSettings:
        """What the first parameter file of the workspace that speaks of servo says."""
        known = {name for name in ServoSettings.__slots__ if name != "is_declared"}
        table: dict[str, Any] = {}
        for _, key, value in declared_settings(
            self._runtime.packages.values(), b"command_in_type", first=True
        ):
            wanted = type(ServoSettings.__dataclass_fields__[key].default) if key in known else None
            if wanted is float and isinstance(value, int | float) and not isinstance(value, bool):
                table.setdefault(key, float(value))
            elif wanted is str and isinstance(value, str):
                table.setdefault(key, value.rsplit("/", 1)[-1])
        return ServoSettings(**table, is_declared=bool(table))

    @cached_property
    def _arm(self) -> ArmMotion:
        return ArmMotion(self._commands, group=self.settings.move_group_name or None)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name in _STATUS and name.endswith("/status"):
            self._publish_status(name, type_name)
        if change != "advertised":
            return
        last = name.rsplit("/", 1)[-1]
        if type_name == TWIST and last in (
            self.settings.cartesian_command_in_topic,
            "delta_jog_cmds",
        ):
            self._hear(name, type_name, self._if_commanded(self._take_twist))
        elif type_name == JOG and last in (
            self.settings.joint_command_in_topic,
            "joint_delta_jog_cmds",
        ):
            self._hear(name, type_name, self._if_commanded(self._take_jog))
        elif type_name == POSE and last == "pose_target_cmds":
            self._hear(name, type_name, self._if_commanded(self._take_pose))

    # What comes

    def _take_twist(self, topic: str, message: Any) -> None:
        linear, angular = message.twist.linear, message.twist.angular
        asked = np.array([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
        if not self._takes(topic, _TWIST, message.header, asked):
            return
        frame = message.header.frame_id
        pose = self._runtime.client(MoveGroupServer).frame(frame)
        if pose is None:
            known = self._twin.robot.link_names
            self._streams.refuse(topic, f"there is no frame '{frame}'; {one_of(known, frame)}")
        elif not np.isfinite(asked).all():
            self._streams.refuse(topic, "a velocity is not finite")
        else:
            scales = self._scales(self.settings.linear, self.settings.rotational)
            asked = asked * np.repeat(scales, 3) * self._controlled
            turned = [
                rotate(pose.orientation, item) for item in (asked[:3].tolist(), asked[3:].tolist())
            ]
            speeds = self._joint_speeds(np.concatenate(turned))
            self._go(
                topic, "servo_twist", dict(zip(self._arm.joints, speeds.tolist(), strict=True))
            )

    def _take_jog(self, topic: str, message: Any) -> None:
        names, values = (
            list(message.joint_names),
            [float(velocity) for velocity in message.velocities],
        )
        if not self._takes(topic, _JOINT_JOG, message.header, np.array(values)):
            return
        known = self._arm.joints
        unknown = [name for name in names if name not in known]
        if unknown:
            self._streams.refuse(
                topic, f"the arm has no joint '{unknown[0]}'; {one_of(known, unknown[0])}"
            )
        elif len(names) != len(values):
            self._streams.refuse(topic, f"{len(values)} velocities for {len(names)} joints")
        elif not all(map(math.isfinite, values)):
            self._streams.refuse(topic, "a velocity is not finite")
        else:
            (scale,) = self._scales(self.settings.joint)
            asked = {**dict.fromkeys(known, 0.0), **dict(zip(names, values, strict=True))}
            self._go(topic, "servo_jog", {name: scale * item for name, item in asked.items()})

    def _take_pose(self, topic: str, message: Any) -> None:
        del message
        self._streams.refuse(topic, "goals of poses for servo are not simulated, only velocities")

    def _takes(self, topic: str, kind: int, header: Any, asked: Array) -> bool:
        """Whether servo takes a command now; a finding says so of one that would move something."""
        why = self._refusal(kind) or self._age(header)
        if why and np.any(asked):
            self._streams.refuse(topic, why)
        elif self._assumed and np.any(asked):
            words = f"somebody is assumed to have called {self._assumed} of servo: no program does"
            self._commands.report("answer_assumed", words, object_name=self._assumed)
        return not why

    def _refusal(self, kind: int) -> str:
        """Return why servo takes no commands of a type now; empty where it does."""
        begins = self._runtime.distro.value(_BEGINS)
        if begins == _BY_TYPE and self._is_started and self._expected is None:
            # Only another distribution has the service by which it was started.
            self._runtime.distro.decided(_BEGINS, asking_place())
        elif begins == _BY_CALL and not (self._is_started or self._is_called("start_servo")):
            return "servo was not started; call its service start_servo first"
        elif begins == _BY_TYPE and self._expected is None:
            if not self._is_called("switch_command_type"):
                return (
                    "servo does not know which type of commands to take; call its service "
                    "switch_command_type first"
                )
        elif self._expected not in (None, kind):
            return "servo was switched to another type of commands"
        return "servo is stopped" if self._is_paused else ""

    def _age(self, header: Any) -> str:
        """Return why a command is too old; empty where it is not."""
        most_s = self.settings.incoming_command_timeout
        sent_ns = nanoseconds(header.stamp)
        if not sent_ns:
            return "its header has no stamp, so servo takes it for an old one; stamp it with now"
        age_s = (EPOCH_NS + self._scheduler.now_ns - sent_ns) * 1e-9
        if age_s < most_s:
            return ""
        return f"its stamp is {age_s:.2g} s old, and servo's time-out is {most_s:g} s"

    def _is_called(self, service: str) -> bool:
        """Whether a file of the workspace calls a service of servo, or a user is assumed to.

        A user does where no program names a service that starts or holds servo.
        """
        if self._files.call(service):
            return True
        if not any(map(self._files.name, _OF_STATE)):
            self._assumed = service
        return bool(self._assumed)

    @cached_property
    def _files(self) -> LaunchedControllers:
        script = next(map(Path, self._runtime.argv), None)
        return LaunchedControllers(self._runtime.packages.values(), script)

    def _scales(self, *scales: float) -> Array:
        if self.settings.command_in_type != _UNITLESS:
            return np.ones(len(scales))
        if not self.settings.is_declared:
            self._commands.report(
                "assumed_setting",
                "no file of the workspace gives servo its scales: a share of 1 is taken for "
                f"{self.settings.linear:g} m/s, {self.settings.rotational:g} rad/s of the tool, "
                f"{self.settings.joint:g} rad/s of a joint, as by default in MoveIt 2",
            )
        return np.array(scales)

    # How the arm moves

    def _joint_speeds(self, twist: Array) -> Array:
        """Return the velocities of the joints for a velocity of the tool, in the base's axes.

        They are scaled as one where a joint would be too fast, or a singularity is near.
        """
        joints = self._arm.arm
        here = np.array(self._arm.positions())
        jacobian = self._jacobian(here)
        speeds: Array = np.linalg.pinv(jacobian, rcond=1e-4) @ twist
        rated = np.array([joint.velocity_limit for joint in joints])
        most = float(np.max(np.abs(speeds) / rated, initial=0.0))
        scale = 1.0 / max(1.0, most)
        if not np.any(speeds):
            return speeds
        share = self._share_near_singularity(here, speeds, _condition(jacobian))
        slowed: Array = scale * share * speeds
        return slowed

    def _share_near_singularity(self, here: Array, speeds: Array, condition: float) -> float:
        """Return the share of its speed that servo leaves the tool, as MoveIt 2 does."""
        low = self.settings.lower_singularity_threshold
        high = max(self.settings.hard_stop_singularity_threshold, low + 1e-6)
        self._status = _NO_WARNING
        if condition <= low or len(here) < _DIMENSIONS:
            return 1.0
        ahead = here + speeds / np.linalg.norm(speeds) * _AHEAD
        is_leaving = _condition(self._jacobian(ahead)) <= condition
        share = max(0.0, 1.0 - (condition - low) / (high - low) / (2.0 if is_leaving else 1.0))
        self._status = (_LEAVING if is_leaving else _APPROACHING) if share else _HALTED
        if share < _SLOW:
            self._commands.report(
                "command_ignored",
                f"servo {'slows' if share else 'stops'} the tool at a singularity: the condition "
                f"number is {condition:.3g}, and it stops at {high:g}; the arm may have to start "
                "elsewhere",
                may_stream=True,
            )
        return share

    def _jacobian(self, positions: Array) -> Array:
        """Return how the tool moves with each joint, (6, n_joints): linear, then angular."""
        named = dict(zip(self._arm.joints, positions.tolist(), strict=True))
        tool = self._arm.tool or self._twin.robot.base_link
        return self._twin.jacobian(named, tool, self._arm.joints)

    def _go(self, topic: str, kind: str, asked: dict[str, float]) -> None:
        for_s = self.settings.incoming_command_timeout or None
        self._streams.go_on_at(topic, kind, asked, for_s, is_timeout=True)

    # Its services, and what it says of itself

    def _start(self) -> bool:
        self._is_started = True
        return self._pause(False)

    def _set_pause(self, request: Any, answer: Any) -> bool:
        del answer
        return self._pause(bool(request.data))

    def _pause(self, is_paused: bool) -> bool:
        self._is_paused = is_paused
        if is_paused:
            self._arm.stop()
        return True

    def _switch(self, request: Any, answer: Any) -> bool:
        del answer
        is_known = request.command_type in (_JOINT_JOG, _TWIST, _POSE_GOAL)
        if is_known:
            self._expected = request.command_type
        return is_known

    def _control(self, request: Any, answer: Any) -> bool:
        del answer
        names = [f"control_{axis}_{way}" for way in ("translation", "rotation") for axis in "xyz"]
        self._controlled = np.array([float(getattr(request, name)) for name in names])
        return True

    def _drift(self, request: Any, answer: Any) -> bool:
        del request, answer
        self._commands.report(
            "not_simulated",
            "servo is let drift in some directions: the arm holds them all the same",
        )
        return True

    def _publish_status(self, name: str, type_name: str) -> None:
        if name in self._reported or "servo" not in name:
            return
        self._reported.add(name)

        def status() -> Any:
            message = self._messages.new(type_name)
            setattr(message, _STATUS[type_name], self._status)
            return message

        self._stream(name, type_name, _STATUS_HZ, status, yields=True)


def _condition(jacobian: Array) -> float:
    values = np.linalg.svd(jacobian, compute_uv=False)
    return float(values[0] / max(values[-1], 1e-12))
