"""What a described driver is made of: its state, its arms, and which case and name is meant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import DriverError, one_of
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.streams.command_streams import CommandStreams
from tracerisk.ros.robot.trajectories.joint_names import JointNames
from tracerisk.ros.robot.trajectories.trajectory_rules import TrajectoryRules
from tracerisk.ros.vendors.answers import Answers
from tracerisk.ros.vendors.described.described_motions import DescribedMotions
from tracerisk.ros.vendors.described.motion_queue import MotionQueue
from tracerisk.ros.vendors.description import Case, Driver, Interface
from tracerisk.ros.vendors.requests import Request
from tracerisk.twin.physics.motion import PlanningError

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.robots.robot import Robot


class DriverState(dict[str, Any]):
    """The driver's own state by name; with it that of its motions, and parameters.

    `queue` holds the motions of its arms, `grips` those of its grippers.
    """

    def __init__(self, driver: Driver, runtime: Runtime) -> None:
        super().__init__(driver.state)
        commands = runtime.client(TwinCommands)
        self.queue = MotionQueue(
            commands,
            driver.errors,
            disables=driver.error_disables,
            remedies=driver.remedies,
            on_error=lambda: self.update(driver.on_error),
        )
        self.grips = MotionQueue(commands, {}, disables=False)
        self._parameters = driver.parameters
        self._tree = runtime.graph.parameters

    def __missing__(self, name: str) -> Any:
        if name in self._parameters:
            set_ = [text for text in self._tree.names() if text.rsplit("/", 1)[-1] == name]
            return self._tree.get(set_[0]) if set_ else self._parameters[name].constant
        of_all = {
            "enabled": self.queue.is_enabled,
            "error": self.queue.error,
            "moving": self.queue.is_busy,
        }
        return of_all[name]


class DescribedArm:
    """One arm of the robot, with its gripper, as a description speaks of it."""

    def __init__(
        self,
        driver: Driver,
        runtime: Runtime,
        messages: TwinMessages,
        state: DriverState,
        group: str | None,
        gripper: str | None,
    ) -> None:
        commands = runtime.client(TwinCommands)
        reading = runtime.client(SensorReading)
        self.motion = ArmMotion(commands, driver.tool, group=group, gripper=gripper)
        self.motions = DescribedMotions(driver, self.motion, state, runtime)
        queues = state.queue, state.grips
        self.answers = Answers(driver, self.motion, *queues, state, messages, reading)


class DescribedStreams:
    """Follows set-points and velocities that come one after the other, by topic or by calls."""

    def __init__(self, commands: TwinCommands) -> None:
        self._streams = CommandStreams(commands)
        self.refuse = self._streams.refuse

    def take(
        self, arm: DescribedArm, interface: Interface, case: Case, name: str, request: Request
    ) -> None:
        """Go on with the stream of a topic or of the calls of a service.

        Raises:
            PlanningError: it cannot be followed.
        """
        kind, motions = short_name(interface), arm.motions
        if case.effect == "move":
            before = self._streams.target(name, arm.motion.joints)
            at = None if before is None else before.tolist()
            target = motions.set_point(case, request, at)
            if target is not None:
                places = np.array(list(target.values()))
                share = motions.share(case, request)
                self._streams.to_position(name, kind, tuple(target), places, speed=share)
                return
        elif "joints" in case.roles:
            asked = motions.speeds(case, request)
            duration = case.roles.get("duration")
            for_s = request.seconds(duration) or None
            is_timeout = duration is not None and duration.is_drivers
            self._streams.go_on_at(name, kind, asked, for_s, is_timeout=is_timeout)
            if not any(asked.values()):
                arm.motion.stop()
            return
        make = motions.move if case.effect == "move" else motions.velocity
        trajectory = make(case, request)()
        if trajectory is None:
            arm.motion.stop()
        else:
            is_set_point = case.effect == "velocity"
            self._streams.follow(name, kind, trajectory, is_set_point=is_set_point)


def lacking_joint(driver: Driver, robot: Robot) -> str:
    """Return a joint that a driver's robots have and this one has not; empty where it is one."""
    known = {joint.name for joint in robot.joints}
    return next((joint for joint in driver.of_joints if joint not in known), "")


def take_rules(driver: Driver, runtime: Runtime) -> None:
    """Give the run a driver's names of joints, and what it does with trajectories.

    A shipped driver is also that of robots without all that its names move: without a gripper.

    Raises:
        DriverError: the robot lacks a joint that a name moves.
    """
    robot = runtime.twin.robot
    known = [joint.name for joint in robot.joints]
    names = {}
    for name, named_joints in driver.joints.items():
        lacking = next((joint for joint in named_joints.meaning.moves if joint not in known), None)
        if lacking is None and name not in known:
            names[name] = named_joints.meaning
        elif lacking is not None and driver.origin == "user":
            raise DriverError(
                f"joints.{name}.moves: robot '{robot.name}' has no joint '{lacking}'; "
                f"{one_of(known, lacking)}; if the driver is that of another robot, give its "
                "joints as 'of_joints'",
                named_joints.location,
            )
    runtime.client(JointNames).add(names)
    rules = runtime.client(TrajectoryRules)
    rules.stop_at_limits |= driver.stop_at_limits
    rules.ignore_tolerances |= driver.ignore_tolerances


def case_of(interface: Interface, request: Request) -> Case:
    """Return the first case that a message meets.

    Raises:
        PlanningError: none does.
    """
    result = next((case for case in interface.cases if request.meets(case)), None)
    if result is not None:
        return result
    allowed: Mapping[str, str] = {
        text: "" for case in interface.cases for one in case.when for text in map(str, one.values)
    }
    (one, *_) = interface.cases[0].when
    raise PlanningError(
        "bad_request", f"{one.path} {request.of(one)} is not simulated; {one_of(allowed)}"
    )


def is_named(described: str, name: str) -> bool:
    """Return whether a full name is that of the description, in any namespace."""
    return described == "*" or f"/{name.strip('/')}".endswith(f"/{described.strip('/')}")


def short_name(interface: Interface) -> str:
    """Return what findings call an interface."""
    return interface.name.strip("/").rsplit("/", 1)[-1]
