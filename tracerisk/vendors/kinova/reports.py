"""What the driver of a Kinova arm reports: angles, poses, the gripper, and cyclic feedback."""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change, ServiceFailedError
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import JOINTS, TwinNode
from tracerisk.vendors.kinova.actions import KortexArm, write_pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_FEEDBACK = "kortex_driver/BaseCyclic_Feedback"
_HZ = 40.0  # cyclic_data_publish_rate of kortex_driver.launch
_L53, _L31 = 1, 2  # ModelId of the Gen3 and of the Gen3 lite


class KortexReports(TwinNode):
    """Answers questions, and publishes the feedback while somebody listens to it."""

    node = "/kortex_driver"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands, ("tool_frame",))
        self._kortex = KortexArm(self._arm)
        self._graph.watch(self._on_change)

    # Answers

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
        angles = [each.value for each in request.input.joint_angles]
        if len(angles) != len(self._arm.joints):
            raise ServiceFailedError(
                f"{len(angles)} joint angles for {len(self._arm.joints)} joints"
            )
        write_pose(answer.output, self._arm.pose_at(self._kortex.goal(angles)))

    # Feedback

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


def joint_angles(messages: TwinMessages, positions: Sequence[float]) -> list[Any]:
    """Return messages JointAngle of joint positions [rad]."""
    angles = []
    for number, position in enumerate(positions):
        angle = messages.new("kortex_driver/JointAngle")
        angle.joint_identifier, angle.value = number, math.degrees(position) % 360.0
        angles.append(angle)
    return angles
