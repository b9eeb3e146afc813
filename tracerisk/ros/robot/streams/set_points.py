"""Topics that command joints: trajectories, positions of a group, of one joint, joint states.

Joint states are commands where a driver takes them: those of simulators and of bridges to them
(`joint_command` of Isaac Sim, `topic_based_joint_commands` of topic_based_ros2_control), and those
of MoveIt's fake controllers. What is published on `joint_states` itself is feedback; it moves no
real robot.

Numbers are velocities, and not positions, where the controller that a file of the workspace
declares says so, or else the topic's name. Joints keep a velocity until the next message, as those
of `JointGroupVelocityController` do.

A stream of set-points is one command for as long as it goes on from the same place in the source:
it is live until its joints have settled and nothing more has come for a while.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.ros.graph.declared_controllers import DeclaredControllers
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.bring_up.system import SystemState
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import SHORT_S, CommandStreams
from tracerisk.ros.robot.streams.command_topics import (
    GROUP,
    JOINT_STATE_TYPE,
    SAYS_COMMANDS,
    SINGLE,
    TRAJECTORY,
    group_joints,
    is_command_topic,
    joint_by_number,
    single_joint,
)
from tracerisk.ros.robot.trajectories.controllers import TrajectoryController, TrajectoryControllers
from tracerisk.ros.robot.trajectories.follow import EMPTY
from tracerisk.ros.robot.trajectories.timed import left_out
from tracerisk.ros.robot.trajectories.trajectory_rules import stopped_positions
from tracerisk.ros.robot.trajectory_messages import (
    TrajectoryNode,
    TrajectoryRefusedError,
    of_its_joints,
    twin_trajectory,
)
from tracerisk.twin.motion.execution import GOAL_TOLERANCE
from tracerisk.twin.motion.plausible_units import unit_guess
from tracerisk.twin.physics.motion import JointTrajectory

_FEEDBACK = "joint_states"
_INDUSTRIAL = "joint_path_command"  # the topic of the drivers of ROS-Industrial
_QUANTITY = re.compile(
    r"(?<=[/_])(?:(pos|positions?)|(vel|velocity|velocities)|(efforts?|torques?))(?=[/_])"
)
_GROUP_COMMAND = "joint_group_command"
_NEARLY = 0.05  # of the goal of a motion whose time is over: the joints come to rest [rad or m]
Array = NDArray[np.float64]


class SetPoints(TrajectoryNode):
    """Listens to the command topics that a controller publishes, and moves the twin.

    A topic that the controller itself subscribes to is its own affair, and moves nothing.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._declared = runtime.client(DeclaredControllers)
        self._controllers = runtime.client(TrajectoryControllers)
        self._states = runtime.client(ControllerStates)
        self._streams = CommandStreams(self._commands)
        self._takers = {
            TRAJECTORY: self._take_trajectory,
            GROUP: self._take_group,
            SINGLE: self._take_single,
            JOINT_STATE_TYPE: self._take_states,
        }
        self._graph.watch(self._on_change)

    def _on_change(self, change: Change, name: str, type_name: str) -> None:
        if change != "advertised" or type_name not in self._takers or name in self._heard:
            return
        if not is_command_topic(name, type_name):
            if type_name == JOINT_STATE_TYPE and name.endswith(f"/{_FEEDBACK}"):
                self._note_feedback(name)
            return
        if words := self._runtime.client(SystemState).words_of_slip(name, type_name):
            self._commands.report("name_assumed", f"topic {words}", object_name=name)
        take = self._if_commanded(self._if_active(self._takers[type_name]))

        def deliver(message: Any, publication: Publication) -> None:
            if not publication.by_controller or self._is_of_a_driver(name, type_name):
                return
            if type_name == TRAJECTORY:
                message = self._by_joints(name, message)
                if message is None:
                    return
            if publication.pace.is_of_loop and self._is_there(message):
                # A loop that sends one trajectory all the time does so, too, once it is there.
                return
            take(message, publication)

        self._hear(name, type_name, deliver)

    def _is_of_a_driver(self, topic: str, type_name: str) -> bool:
        """Return whether a maker's driver takes the numbers of a topic, in units of its own."""
        heard = self._graph.subscriptions(topic) if type_name == SINGLE else ()
        return any(
            not subscription.by_controller and subscription.node != self.node
            for subscription in heard
        )

    def _if_active(self, take: Callable[[str, Any], None]) -> Callable[[str, Any], None]:
        """Return what passes on what its controller takes in the state that it is in."""

        def deliver(topic: str, message: Any) -> None:
            if refusal := self._states.refusal(topic):
                self._refuse(topic, refusal)
            else:
                take(topic, message)

        return deliver

    def _by_joints(self, topic: str, message: Any) -> Any | None:
        """Return a trajectory by the names of the robot's own joints, None where it moves none."""
        self._report_unmoved(f"a message on {topic}", message.joint_names)
        made = self._names.trajectory(message)
        return made if made is message or made.joint_names else None

    def _take_trajectory(self, topic: str, message: Any) -> None:
        controller = self._controllers.of(topic, message.joint_names)
        stops = self._is_drivers or self._runtime.distro.value(EMPTY) == "stops the joints"
        if not message.points and stops:
            self._commands.stop(controller.joints)
            return
        try:
            trajectory = self._trajectory(topic, message, controller)
        except TrajectoryRefusedError as error:
            if not (error.is_late and self._is_there(message, _NEARLY)):
                self._refuse(topic, str(error))
            return
        self._note_space(topic, trajectory.joints)
        trajectory = self._stopped(f"a message on {topic}", trajectory)
        taken = None if controller is None else controller.taken_over
        if len(message.points) == 1 and (asked_s := _asked_s(message.points[0])) <= SHORT_S:
            joints, goal = trajectory.joints, trajectory.position[-1]
            self._streams.to_position(
                topic, "joint_trajectory", joints, goal, due_s=asked_s, taken=taken
            )
            return
        self._streams.follow(topic, "joint_trajectory", trajectory, is_set_point=False, taken=taken)

    def _trajectory(
        self, topic: str, message: Any, controller: TrajectoryController
    ) -> JointTrajectory:
        now_ns = self._scheduler.now_ns
        if topic.rpartition("/")[2] == _INDUSTRIAL:
            return twin_trajectory(of_its_joints(message), self._twin, now_ns)
        if self._is_drivers:
            return twin_trajectory(message, self._twin, now_ns)
        sent = controller.asked(message, now_ns)
        if not sent.points:
            raise TrajectoryRefusedError("the trajectory has no points")
        trajectory = controller.trajectory(sent, self._commands.stack())
        if words := left_out(sent, self._twin, f"a message on {topic}"):
            self._commands.report("command_ignored", words, object_name=topic, may_stream=True)
        return trajectory

    def _is_there(self, message: Any, tolerance: float = GOAL_TOLERANCE) -> bool:
        """Return whether the joints are where a trajectory ends; of other messages, False."""
        points = getattr(message, "points", None)
        if not points or len(points[-1].positions) != len(message.joint_names):
            return False
        here = self._twin.joint_state().positions
        goal = zip(message.joint_names, points[-1].positions, strict=True)
        return all(abs(here.get(name, math.inf) - value) <= tolerance for name, value in goal)

    def _take_group(self, topic: str, message: Any) -> None:
        values = [float(value) for value in message.data]
        if SAYS_COMMANDS.match(topic.rsplit("/", 1)[-1]):
            self._take_assumed(topic, values)
            return
        joints = self._declared_joints(topic, len(values))
        own = self._joints_declared_for(topic)
        if joints is None and own and {joint.name for joint in self._twin.robot.joints} >= {*own}:
            self._refuse(
                topic, f"it has {len(values)} values, and its controller {len(own)} joints"
            )
            return
        if joints is None:
            joints = group_joints(self._twin.robot, topic, len(values))
        if not joints:
            self._refuse_group(topic, len(values))
            return
        self._command(topic, joints, np.array(values), _GROUP_COMMAND)

    def _take_assumed(self, topic: str, values: list[float]) -> None:
        """Move the arm as a forward controller would whose topic a bring-up has renamed.

        Such a controller takes one value for each joint, and passes over messages with another
        number (ros-controls/ros2_controllers
        `forward_command_controller/src/forward_controllers_base.cpp`). It is assumed only where
        the values are as many as the joints of the arm, and positions that these can reach.
        """
        arm = self._twin.robot.arm_joints
        fits = len(values) == len(arm) and all(
            joint.lower - _NEARLY <= value <= joint.upper + _NEARLY
            for joint, value in zip(arm, values, strict=True)
        )
        if any(subscription.node != self.node for subscription in self._graph.subscriptions(topic)):
            return
        if not fits:
            words = f"messages on {topic} moved nothing: no known controller takes them"
            self._commands.report("unprovided", words, object_name=topic)
            return
        joints = tuple(joint.name for joint in arm)
        words = f"go to a forward position controller of {', '.join(joints)}, which is assumed"
        self._commands.report("answer_assumed", f"messages on {topic} {words}", object_name=topic)
        self._command(topic, joints, np.array(values), _GROUP_COMMAND)

    def _command(self, topic: str, joints: tuple[str, ...], values: Array, kind: str) -> None:
        """Bring joints to positions, or move them at velocities, as the topic means its numbers."""
        self._note_space(topic, joints)
        quantity = self._quantity(topic)
        if quantity == "position":
            self._go_to(topic, kind, joints, values)
        elif quantity == "velocity":
            self._go_on_at(topic, joints, values, kind.replace("command", "velocity"))
        else:
            self._refuse(topic, f"commands of {quantity} are not simulated")

    def _go_to(self, topic: str, kind: str, joints: tuple[str, ...], values: Array) -> None:
        """Bring joints to positions, and those that are sent past a limit to that limit.

        Controllers of single positions limit what they are sent, or the interface of the joint
        does. A value that looks like another unit, or that is not finite, is passed on unchanged,
        and the command fails.
        """
        robot = self._twin.robot
        (reached,), past = stopped_positions(joints, values[None, :], robot)
        in_doubt = any(
            not math.isfinite(value) or unit_guess(robot.joint(name), value)
            for name, value in zip(joints, values.tolist(), strict=True)
            if name in past
        )
        if in_doubt:
            reached, past = values, {}
        for joint, words in past.items():
            self._commands.report(
                "stopped_at_limit",
                f"a message on {topic} takes joint '{joint}' {words}",
                object_name=joint,
                may_stream=True,
            )
        self._streams.to_position(topic, kind, joints, reached)

    def _quantity(self, topic: str) -> str:
        declared = self._declared.of_topic(topic)
        if declared is not None and declared.quantity:
            return declared.quantity
        named = [match_.lastindex for match_ in _QUANTITY.finditer(topic)]
        return {2: "velocity", 3: "effort"}.get(named[-1] or 0, "position") if named else "position"

    def _go_on_at(self, topic: str, joints: tuple[str, ...], speeds: Array, kind: str) -> None:
        """Move joints at velocities [rad/s or m/s] until the next message, or their limits."""
        if not np.isfinite(speeds).all():
            self._refuse(topic, "a velocity is not finite")
            return
        asked = dict(zip(joints, speeds.tolist(), strict=True))
        self._streams.go_on_at(topic, kind, asked, None)

    def _declared_joints(self, topic: str, count: int) -> tuple[str, ...] | None:
        """Return the joints of the workspace's controller for a topic, if the robot has them."""
        declared = self._joints_declared_for(topic)
        known = {joint.name for joint in self._twin.robot.joints}
        return declared if len(declared) == count and known.issuperset(declared) else None

    def _joints_declared_for(self, topic: str) -> tuple[str, ...]:
        declared = self._declared.of_topic(topic)
        return () if declared is None else declared.joints

    def _refuse_group(self, topic: str, count: int) -> None:
        robot = self._twin.robot
        declared = self._joints_declared_for(topic)
        if not declared or any(joint.name in declared for joint in robot.joints):
            self._refuse(
                topic, f"{count} values fit no controller or group of robot '{robot.name}'"
            )
            return
        # The same program drives a robot that has them.
        self._commands.report(
            "unprovided",
            f"messages on {topic} moved nothing: the workspace has a controller for "
            f"{', '.join(declared)}, and robot '{robot.name}' has no such joint",
            object_name=topic,
        )

    def _take_single(self, topic: str, message: Any) -> None:
        joint = self._declared_joint(topic) or single_joint(self._twin.robot, topic)
        if joint is None and not self._declares_own():
            joint = joint_by_number(self._twin.robot, topic, self._heard)
            if joint is not None:
                words = f"go to joint '{joint}', by their number, which is assumed"
                said = f"messages on {topic} {words}: no joint of the robot is named so"
                self._commands.report("answer_assumed", said, object_name=topic)
        if joint is None:
            names = ", ".join(item.name for item in self._twin.robot.joints)
            self._refuse(topic, f"no joint of the robot is meant; it has {names}")
            return
        self._command(topic, (joint,), np.array([float(message.data)]), "joint_command")

    def _declared_joint(self, topic: str) -> str | None:
        """Return the robot's joint that a file gives the controller of a topic, if one does."""
        declared = self._declared.of_robot(joint.name for joint in self._twin.robot.joints)
        named = [part for part in topic.split("/")[:-1] if part in declared]
        joints = declared[named[-1]].joints if named else ()
        return joints[0] if len(joints) == 1 else None

    def _declares_own(self) -> bool:
        """Return whether the workspace has controllers for joints that the robot has."""
        joints = (joint.name for joint in self._twin.robot.joints)
        return any(declared.joints for declared in self._declared.of_robot(joints).values())

    def _take_states(self, topic: str, message: Any) -> None:
        robot = self._twin.robot
        names, values = list(message.name), [float(value) for value in message.position]
        known = {joint.name for joint in robot.joints}
        unknown = [name for name in names if name not in known]
        speeds = [float(value) for value in message.velocity]
        is_velocity = not values and len(speeds) > 0
        values = speeds if is_velocity else values
        if len(names) == len(values) and self._names.has_any(names):
            self._report_unmoved(f"a message on {topic}", names)
            spread = self._names.spread(names, values)
            names, values = [*spread], [*spread.values()]
            unknown = [name for name in names if name not in known]
            if not names:
                return
        if not values and len(message.effort):
            self._refuse(topic, "commands of effort are not simulated")
        elif not names or len(names) != len(values):
            given = "velocities" if is_velocity else "positions"
            self._refuse(topic, f"{len(values)} {given} for {len(names)} names of joints")
        elif unknown:
            self._refuse(
                topic,
                f"robot '{robot.name}' has no joint '{unknown[0]}'; {one_of(known, unknown[0])}",
            )
        elif is_velocity:
            self._go_on_at(topic, tuple(names), np.array(values), "joint_state_velocity")
        else:
            self._go_to(topic, "joint_state_command", tuple(names), np.array(values))

    def _note_feedback(self, topic: str) -> None:
        """Report that joint states published by the controller move nothing, unless a driver obeys.

        Drivers listen before it; a scenario may describe one that takes them for commands.
        """
        if any(not subscription.by_controller for subscription in self._graph.subscriptions(topic)):
            return
        if any(publication.by_controller for publication in self._graph.publications(topic)):
            self._commands.report(
                "not_simulated",
                f"joint states published on {topic} move nothing: a driver publishes there what "
                "it measured, and takes commands elsewhere",
            )

    def _refuse(self, topic: str, message: str) -> None:
        self._commands.report(
            "command_ignored",
            f"a message on {topic} moved nothing: {message}",
            object_name=topic,
            may_stream=True,
        )


def _asked_s(point: Any) -> float:
    return nanoseconds(point.time_from_start) * 1e-9
