"""The driver of Kinova's Gen3 and Gen3 lite on the graph: services, actions and notifications.

Source of names and behaviour: Kinovarobotics/ros_kortex, kortex_driver (readme, srv, msg, and
kortex_arm_simulation.cpp, the driver's own simulated arm).
"""

# ruff: noqa: ARG002, ARG005 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.ros.vendors.kinova.actions import KortexArm, joint_angles, pose_of, write_pose
from tracerisk.ros.vendors.kinova.player import DEFAULTS, REACH_ANGLES, REACH_POSE, KortexPlayer
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import PlanningError

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "kortex_driver"
FOLLOW_CARTESIAN = f"{PACKAGE}/FollowCartesianTrajectory"

_FEEDBACK = f"{PACKAGE}/BaseCyclic_Feedback"
_HZ = 40.0  # cyclic_data_publish_rate of kortex_driver.launch
_L53, _L31 = 1, 2  # ModelId of the Gen3 and of the Gen3 lite
_FIRST_CREATED = 10000
_SINGLE_LEVEL = 2  # ServoingMode
_IN_FAULT, _SERVOING_READY = 4, 7  # ArmState
_INVALID_GOAL, _PATH_VIOLATED = -1, -2  # of FollowCartesianTrajectory
# Where the name of the service does not give that of its type.
_TYPES = {
    "clear_faults": "Base_ClearFaults",
    "activate_publishing_of_action_topic": "OnNotificationActionTopic",
}
_NOT_SIMULATED = (
    "pause_action",
    "resume_action",
    "play_pre_computed_joint_trajectory",
    "send_wrench_command",
    "send_wrench_joystick_command",
    "set_admittance",
)
_VELOCITY_TOPICS = {
    f"{PACKAGE}/Base_JointSpeeds": "send_joint_speeds",
    f"{PACKAGE}/TwistCommand": "send_twist_command",
}

Handler = Callable[[Any, Any], None]


class KortexDriver(TwinNode):
    """Answers as the driver of the twin's arm, in any namespace."""

    node = "/kortex_driver"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands, ("tool_frame",))
        self._kortex = KortexArm(self._arm)
        self._player = KortexPlayer(self._kortex, messages, self._commands, self._notify)
        self._topics: dict[str, Publication] = {}
        self._is_notifying = False
        self._graph.watch(self._on_change)
        if not messages.has("service", f"{PACKAGE}/ExecuteAction"):
            return
        for space, services in (("base", self._base()), ("control_config", self._config())):
            for name, handle in services.items():
                kind = _TYPES.get(name, "".join(part.capitalize() for part in name.split("_")))
                self._offer(f"{space}/{name}", f"{PACKAGE}/{kind}", handle)
        self._offer_parameters(PACKAGE, self._parameters())
        self._graph.watch(self._on_topic)

    def _base(self) -> Mapping[str, Handler]:
        player, kortex = self._player, self._kortex
        return {
            "clear_faults": lambda asked, _: player.do("clear_faults", asked, 0),
            "read_action": self._read_action,
            "read_all_actions": self._read_all_actions,
            "create_action": self._create_action,
            "update_action": self._update_action,
            "delete_action": self._delete_action,
            "execute_action": lambda asked, _: player.execute(asked.input),
            "execute_action_from_reference": lambda asked, _: player.execute(
                player.stored(asked.input.identifier)
            ),
            "stop_action": lambda asked, _: player.stop(),
            "stop": lambda asked, _: player.stop(),
            "apply_emergency_stop": lambda asked, _: player.do("apply_emergency_stop", asked, 0),
            "play_joint_trajectory": partial(self._do, "reach_joint_angles"),
            "play_cartesian_trajectory": partial(self._do, "reach_pose"),
            "execute_waypoint_trajectory": partial(self._do, "execute_waypoint_list"),
            "play_selected_joint_trajectory": lambda asked, _: player.play(
                partial(kortex.reach_angle, asked.input), REACH_ANGLES
            ),
            "play_cartesian_trajectory_position": lambda asked, _: player.play(
                partial(kortex.reach_position, asked.input), REACH_POSE
            ),
            "play_cartesian_trajectory_orientation": lambda asked, _: player.play(
                partial(kortex.reach_orientation, asked.input), REACH_POSE
            ),
            "send_joint_speeds_command": partial(self._do, "send_joint_speeds"),
            "send_joint_speeds_joystick_command": partial(self._do, "send_joint_speeds"),
            "send_twist_command": partial(self._do, "send_twist_command"),
            "send_twist_joystick_command": partial(self._do, "send_twist_command"),
            "send_gripper_command": partial(self._do, "send_gripper_command"),
            "validate_waypoint_list": self._validate,
            "activate_publishing_of_action_topic": self._begin_to_notify,
            "get_product_configuration": self._product,
            "get_actuator_count": self._count,
            "get_measured_joint_angles": self._measured_angles,
            "get_measured_cartesian_pose": self._measured_pose,
            "get_measured_gripper_movement": self._measured_gripper,
            "compute_forward_kinematics": self._forward,
            "compute_inverse_kinematics": self._inverse,
            "get_arm_state": self._arm_state,
            "get_servoing_mode": self._servoing_mode,
            "set_servoing_mode": self._set_servoing_mode,
            **{name: partial(self._refuse, name) for name in _NOT_SIMULATED},
        }

    def _config(self) -> Mapping[str, Handler]:
        return {
            "set_cartesian_reference_frame": self._set_frame,
            "get_cartesian_reference_frame": self._get_frame,
        }

    def _parameters(self) -> Mapping[str, Any]:
        gripper = self._arm.gripper
        return {
            "degrees_of_freedom": len(self._arm.joints),
            "is_gripper_present": gripper is not None,
            "gripper_joint_names": [] if gripper is None else [gripper.joints[0]],
            "has_vision_module": False,
            "has_interconnect_module": False,
            "is_initialized": True,
        }

    def _do(self, kind: str, request: Any, answer: Any) -> None:
        self._player.do(kind, request.input, 0)

    def _refuse(self, name: str, request: Any, answer: Any) -> None:
        raise self._player.refused(f"service {name} is not simulated: nothing moved")

    # Topics

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == _FEEDBACK:
            self._report_on(name, type_name, _HZ, self._feedback, JOINTS)

    def _feedback(self, message: Any, topic: str) -> Any:
        x, y, z = (pose := self._arm.tool_pose()).position
        turns = write_pose(self._messages.new("kortex_driver/Pose"), pose)
        for prefix in ("tool_pose", "commanded_tool_pose"):
            for axis, value in zip("xyz", (x, y, z), strict=True):
                setattr(message.base, f"{prefix}_{axis}", value)
                setattr(message.base, f"{prefix}_theta_{axis}", getattr(turns, f"theta_{axis}"))
        measured = (self._arm.velocities(), self._arm.efforts())
        for angle, speed, effort in zip(self._kortex.angles(), *measured, strict=True):
            actuator = self._messages.new("kortex_driver/ActuatorFeedback")
            actuator.position, actuator.velocity = angle, math.degrees(speed)
            actuator.torque = effort
            message.actuators.append(actuator)
        if self._arm.gripper is not None:
            gripper = self._messages.new("kortex_driver/GripperCyclic_Feedback")
            motor = self._messages.new("kortex_driver/MotorFeedback")
            motor.position = 100.0 * (1.0 - self._arm.grip())
            gripper.motor.append(motor)
            message.interconnect.oneof_tool_feedback.gripper_feedback.append(gripper)
        return message

    def _on_topic(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == f"{PACKAGE}/ActionNotification":
            if name not in self._topics:
                self._topics[name] = self._graph.advertise(
                    name, type_name, node=self.node, by_controller=False
                )
        elif change == "advertised" and type_name in _VELOCITY_TOPICS:
            kind = _VELOCITY_TOPICS[type_name]
            self._hear(
                name,
                type_name,
                lambda message, _: self._player.do(kind, message, 0, is_answered=False),
            )

    def _begin_to_notify(self, request: Any, answer: Any) -> None:
        self._is_notifying = True

    def _notify(self, event: int, kind: int, identifier: int, detail: int) -> None:
        for publication in self._topics.values() if self._is_notifying else ():
            message = self._messages.new(f"{PACKAGE}/ActionNotification")
            message.action_event, message.abort_details = event, detail
            message.handle.identifier, message.handle.action_type = identifier, kind
            seconds, rest = divmod(self._scheduler.now_ns, 1_000_000_000)
            message.timestamp.sec, message.timestamp.usec = seconds, rest // 1000
            publication.publish(message)

    # Questions

    def _product(self, request: Any, answer: Any) -> None:
        is_lite = "lite" in self._arm.twin.robot.name
        answer.output.model = _L31 if is_lite else _L53
        answer.output.degree_of_freedom = len(self._arm.joints)

    def _count(self, request: Any, answer: Any) -> None:
        answer.output.count = len(self._arm.joints)

    def _measured_angles(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        self._reading.asked("encoder")
        answer.output.joint_angles = joint_angles(self._messages, self._arm.positions())

    def _measured_pose(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        self._reading.asked("encoder")
        write_pose(answer.output, self._arm.tool_pose())

    def _measured_gripper(self, request: Any, answer: Any) -> None:
        self._scheduler.touch()
        finger = self._messages.new("kortex_driver/Finger")
        finger.finger_identifier, finger.value = 1, 1.0 - self._arm.grip()
        answer.output.finger = [finger]

    def _forward(self, request: Any, answer: Any) -> None:
        angles = [joint_angle.value for joint_angle in request.input.joint_angles]
        if len(angles) != len(self._arm.joints):
            raise ServiceFailedError(
                f"{len(angles)} joint angles for {len(self._arm.joints)} joints"
            )
        write_pose(answer.output, self._arm.pose_at(self._kortex.goal(angles)))

    # Stored actions

    def _read_action(self, request: Any, answer: Any) -> None:
        answer.output = self._player.stored(request.input.identifier)

    def _read_all_actions(self, request: Any, answer: Any) -> None:
        kind = request.input.action_type
        actions = [
            self._player.stored(identifier)
            for identifier in (*DEFAULTS, *sorted(self._player.created))
        ]
        answer.output.action_list = [
            action for action in actions if kind in (0, action.handle.action_type)
        ]

    def _create_action(self, request: Any, answer: Any) -> None:
        action = request.input
        self._player.kind_of(action)
        action.handle.identifier = max((_FIRST_CREATED - 1, *self._player.created)) + 1
        action.handle.permission = 7
        self._player.created[action.handle.identifier] = action
        answer.output = action.handle

    def _update_action(self, request: Any, answer: Any) -> None:
        if request.input.handle.identifier not in self._player.created:
            raise ServiceFailedError(f"no created action {request.input.handle.identifier}")
        self._player.created[request.input.handle.identifier] = request.input

    def _delete_action(self, request: Any, answer: Any) -> None:
        if self._player.created.pop(request.input.identifier, None) is None:
            raise ServiceFailedError(f"no created action {request.input.identifier}")

    # States

    def _arm_state(self, request: Any, answer: Any) -> None:
        answer.output.active_state = _IN_FAULT if self._player.is_stopped else _SERVOING_READY

    def _servoing_mode(self, request: Any, answer: Any) -> None:
        answer.output.servoing_mode = _SINGLE_LEVEL

    def _set_servoing_mode(self, request: Any, answer: Any) -> None:
        if request.input.servoing_mode != _SINGLE_LEVEL:
            raise self._player.refused(
                f"servoing mode {request.input.servoing_mode} is not simulated; allowed: 2, "
                "single-level servoing"
            )

    def _set_frame(self, request: Any, answer: Any) -> None:
        self._player.frame = request.input.reference_frame or 1

    def _get_frame(self, request: Any, answer: Any) -> None:
        answer.output.reference_frame = self._player.frame

    def _validate(self, request: Any, answer: Any) -> None:
        for error in self._kortex.errors(request.input):
            element = self._messages.new(f"{PACKAGE}/TrajectoryErrorElement")
            element.error_type, element.error_identifier = error.type, error.identifier
            element.message, element.index = error.message, error.joint
            element.waypoint_index, element.error_value = error.waypoint, error.value
            element.min_value, element.max_value = error.least, error.most
            answer.output.trajectory_error_report.trajectory_error_elements.append(element)
        answer.output.optimal_waypoint_list = request.input

    def _inverse(self, request: Any, answer: Any) -> None:
        asked = request.input
        guess = self._kortex.goal([joint_angle.value for joint_angle in asked.guess.joint_angles])
        try:
            reach = self._arm.reach(pose_of(asked.cartesian_pose), guess)
        except PlanningError as error:
            raise ServiceFailedError(error.message) from error
        answer.output.joint_angles = joint_angles(self._messages, reach)

    # The action of cartesian trajectories

    def follow_cartesian(self, goal: ActionGoal) -> None:
        """Take a goal of FollowCartesianTrajectory, whose turns are in [rad]."""
        goal.accept()
        self._player.interrupt()
        try:
            if not goal.message.trajectory:
                raise PlanningError("invalid_goal", "the trajectory is empty")
            trajectory = self._kortex.poses(goal.message.trajectory, in_degrees=False)
        except PlanningError as error:
            self._player.report_idle(error.message, goal.stack)
            goal.abort(self._result(_INVALID_GOAL, error.message), error.message)
            return

        def ended(motion: Motion) -> None:
            text = "" if motion.outcome == "succeeded" else motion.message
            code = _PATH_VIOLATED if motion.outcome == "aborted" else 0
            goal.end(motion.outcome, self._result(code, text), text)

        self._arm.start("kortex_action", trajectory, goal.stack, ended, goal=goal)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Bring the arm to rest; the goal ends with its motion."""
        goal.accept_cancel()
        if goal.motion is not None and goal.motion.outcome == "active":
            self._arm.stop()

    def _result(self, code: int, message: str) -> Any:
        result = self._messages.part(FOLLOW_CARTESIAN, "Result")
        result.error_code, result.error_string = code, message
        return result
