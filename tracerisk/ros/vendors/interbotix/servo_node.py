"""The servos of an Interbotix arm behind either of its drivers: what they report and carry out.

Joint states are published where a driver's services are asked for, with the gripper's servo among
them. Source of the behaviour: Interbotix/interbotix_ros_core, interbotix_xs_sdk.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.motion_profiles import at_velocities
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.streams.command_topics import JOINT_STATE_TYPE
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.vendors.interbotix.dynamixel import LARGEST, SETTINGS, Servo, linkage_of
from tracerisk.ros.vendors.interbotix.motion import InterbotixMotion
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.robot_parts import Gripper

GRIPPER = "gripper"
"""The name of the servo that drives the fingers; arms of the series have one."""
TURRET = ("pan", "tilt")
"""The servos that turn a camera, and are no part of the arm."""

_HZ = 100.0  # joint_state_publisher.update_rate of interbotix_xsarm_control/config


class ServoNode(TwinNode):
    """The arm's servos, and the gripper's; each class names the `package` of its messages."""

    package: str
    _takers: Mapping[str, Callable[[str, Any], None]]

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        robot = self._twin.robot
        self._gripper: Gripper | None = next(iter(robot.grippers), None)
        # A description may have a joint for the servo of the gripper, which only turns a picture.
        servos = tuple(joint.name for joint in robot.arm_joints if joint.name != GRIPPER)
        self._arm = tuple(name for name in servos if name not in TURRET)
        if self._gripper is not None:
            servos += (GRIPPER,)
        self._servos = {name: Servo() for name in servos}
        if self._gripper is not None:
            self._servos[GRIPPER] = Servo("pwm", "velocity", True, dict.fromkeys(SETTINGS, 0))
        self._linkage = linkage_of(robot.name)
        self._streams = CommandStreams(self._commands)
        self._motion = InterbotixMotion(self._twin)
        self._publications: dict[str, Publication] = {}
        self._ticked: dict[str, int] = {}

    # What is found on the graph

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change == "served" and type_name.startswith(f"{self.package}/"):
            self._publish_states(name.rsplit("/", 1)[0] + "/joint_states")
        elif change == "advertised" and self._takes(name, type_name):
            take = self._takers[type_name]
            self._hear(name, type_name, lambda message, _: take(name, message))
        elif change == "subscribed" and type_name == JOINT_STATE_TYPE:
            spaces = [topic.rsplit("/", 1)[0] for topic in self._publications]
            if any(space and name.startswith(space + "/") for space in spaces):
                # Robots of several drivers publish below their namespace.
                self._publish_states(name)
            if name in self._publications:
                self._go_on(name)

    def _takes(self, name: str, type_name: str) -> bool:
        """Return whether the driver takes a topic for a command."""
        del name
        return type_name in self._takers

    def _publish_states(self, topic: str) -> None:
        # The twin's own joint states need no second publisher.
        if topic not in self._publications and topic != "/joint_states":
            advertised = self._graph.advertise(
                topic, JOINT_STATE_TYPE, node=self.node, by_controller=False
            )
            self._publications[topic] = advertised
            self._reading.reports_joints(advertised, _HZ)
            self._go_on(topic)

    def _go_on(self, topic: str) -> None:
        period_ns = round(1e9 / _HZ)
        due_ns = (self._scheduler.now_ns // period_ns + 1) * period_ns
        self._scheduler.call_at(due_ns, lambda: self._publish(topic, due_ns), background=True)

    def _publish(self, topic: str, due_ns: int) -> None:
        publication = self._publications[topic]
        if publication.is_wanted and self._ticked.get(topic, -1) < due_ns:
            self._ticked[topic] = due_ns
            publication.publish(self._joint_state())
            self._go_on(topic)

    def _joint_state(self) -> Any:
        state = self._twin.joint_state()
        message = self._messages.new(JOINT_STATE_TYPE)
        self._now(message.header)
        present = [text for text in self._joint_order() if text not in state.absent]
        message.name = self._graph.carrier.world.ordered(present)
        values = {
            name: (state.position[i], state.velocity[i], state.effort[i])
            for i, name in enumerate(state.names)
        }
        if self._gripper is not None:
            finger, speed, effort = values[self._gripper.joints[0]]
            angle = self._linkage.angle(abs(finger))
            ahead = self._linkage.angle(abs(finger) + 1e-6)
            values[GRIPPER] = angle, speed * (ahead - angle) * 1e6, effort
        rows = [values[name] for name in message.name]
        message.position = [row[0] for row in rows]
        message.velocity = [row[1] for row in rows]
        message.effort = [row[2] for row in rows]
        return message

    def _joint_order(self) -> list[str]:
        fingers = () if self._gripper is None else self._gripper.joints
        return [*self._servos, *fingers]

    def _shown(self, servo: str) -> str:
        return self._gripper.joints[0] if servo == GRIPPER and self._gripper else servo

    def _asleep(self) -> dict[str, float]:
        robot = self._twin.robot
        asleep = dict(robot.initial_state)
        for states in robot.named_states.values():
            for name, state in states.items():
                if name.lower() == "sleep":
                    asleep.update(state)
        return asleep

    # Commands

    def _command(
        self, topic: str, names: Sequence[str], values: Sequence[float], kind: str
    ) -> None:
        limp = [name for name in names if not self._servos[name].torque]
        if limp:
            self._streams.refuse(topic, f"{', '.join(limp)} is torqued off")
            return
        if not np.isfinite(values).all():
            self._streams.refuse(topic, "a command is not finite")
            return
        asked = dict(zip(names, values, strict=True))
        if GRIPPER in asked:
            self._command_gripper(topic, asked.pop(GRIPPER))
        servos = {name: self._servos[name] for name in asked}
        if not servos:
            return
        if all(servo.is_positional for servo in servos.values()):
            made = self._motion.to_positions(servos, asked)
            self._streams.follow(f"{topic} {' '.join(asked)}", kind, made[0], is_set_point=made[1])
        elif all(servo.mode == "velocity" for servo in servos.values()):
            moving = at_velocities(self._twin, asked)
            if moving is None:
                self._commands.rest(list(asked))
            else:
                key = f"{topic} {' '.join(asked)}"
                self._streams.follow(key, "joint_velocity_command", moving, is_set_point=True)
        else:
            modes = ", ".join(sorted({servo.mode for servo in servos.values()}))
            self._streams.refuse(topic, f"commands in the mode {modes} are not simulated")

    def _command_gripper(self, topic: str, value: float) -> None:
        gripper, servo = self._gripper, self._servos[GRIPPER]
        assert gripper is not None
        effort = None
        if servo.mode in LARGEST:
            if value == 0.0:
                # The gear holds what the fingers hold; nothing drives them on.
                return
            ends = gripper_ends(self._twin.robot, gripper)
            goal = ends.opened if value > 0.0 else ends.closed
            effort = gripper.effort * min(1.0, abs(value) / LARGEST[servo.mode])
        elif servo.is_positional:
            finger = value / 2 if servo.mode == "linear_position" else self._linkage.finger(value)
            goal = min(max(finger, gripper.least), gripper.opening)
        else:
            self._streams.refuse(topic, f"a gripper in the mode {servo.mode} is not simulated")
            return
        try:
            motion = self._twin.move_gripper(gripper.name, goal, max_effort=effort)
        except PlanningError as error:
            self._streams.refuse(topic, error.message)
            return
        self._commands.begin("gripper_command", motion, self._commands.stack())
