"""What the driver of a Kinova arm reports: angles, poses, the gripper, and cyclic feedback."""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.graph import Change, Publication, ServiceFailedError
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.vendors.kinova.actions import KortexArm, write_pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_NODE = "/kortex_driver"
_FEEDBACK = "kortex_driver/BaseCyclic_Feedback"
_HZ = 40.0  # cyclic_data_publish_rate of kortex_driver.launch
_L53, _L31 = 1, 2  # ModelId of the Gen3 and of the Gen3 lite


class KortexReports:
    """Answers questions, and publishes the feedback while somebody listens to it."""

    def __init__(self, runtime: Runtime, messages: TwinMessages, kortex: KortexArm) -> None:
        self._graph, self._scheduler = runtime.graph, runtime.scheduler
        self._messages = messages
        self._kortex = kortex
        self._arm = kortex.arm
        self._reading = runtime.client(SensorReading)
        self._published: set[str] = set()
        self._graph.watch(self._on_change)

    # Answers

    def product(self, request: Any, answer: Any) -> None:
        """Report the model and the number of joints."""
        is_lite = "lite" in self._arm.twin.robot.name
        answer.output.model = _L31 if is_lite else _L53
        answer.output.degree_of_freedom = len(self._arm.joints)

    def count(self, request: Any, answer: Any) -> None:
        """Report the number of joints."""
        answer.output.count = len(self._arm.joints)

    def measured_angles(self, request: Any, answer: Any) -> None:
        """Report where the joints are."""
        self._scheduler.touch()
        self._reading.asked("encoder")
        answer.output.joint_angles = joint_angles(self._messages, self._arm.positions())

    def measured_pose(self, request: Any, answer: Any) -> None:
        """Report where the tool is."""
        self._scheduler.touch()
        self._reading.asked("encoder")
        write_pose(answer.output, self._arm.tool_pose())

    def measured_gripper(self, request: Any, answer: Any) -> None:
        """Report how far the gripper is closed, in its mode of position."""
        self._scheduler.touch()
        finger = self._messages.new("kortex_driver/Finger")
        finger.finger_identifier, finger.value = 1, 1.0 - self._arm.grip()
        answer.output.finger = [finger]

    def forward(self, request: Any, answer: Any) -> None:
        """Report where the tool is at joint angles."""
        angles = [each.value for each in request.input.joint_angles]
        if len(angles) != len(self._arm.joints):
            raise ServiceFailedError(
                f"{len(angles)} joint angles for {len(self._arm.joints)} joints"
            )
        write_pose(answer.output, self._arm.pose_at(self._kortex.goal(angles)))

    # Feedback

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "subscribed" and type_name == _FEEDBACK and name not in self._published:
            self._published.add(name)
            publication = self._graph.advertise(name, type_name, node=_NODE, by_controller=False)
            self._reading.reports_joints(publication, _HZ)
            self._schedule(publication)

    def _schedule(self, publication: Publication) -> None:
        period_ns = round(1e9 / _HZ)
        due_ns = (self._scheduler.now_ns // period_ns + 1) * period_ns
        self._scheduler.call_at(due_ns, lambda: self._report(publication), background=True)

    def _report(self, publication: Publication) -> None:
        if not publication.subscriptions:
            self._published.discard(publication.topic)
            publication.close()
            return
        publication.publish(self._feedback())
        self._schedule(publication)

    def _feedback(self) -> Any:
        message = self._messages.new(_FEEDBACK)
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
