"""The controllers of joint trajectories of a run, each by the names of its action and topics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tracerisk.errors import Location, one_of
from tracerisk.ros.robot.bring_up.states import robot_controllers
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.trajectories.checks import (
    EFFORT,
    END_VELOCITY,
    Asked,
    check,
    check_joints,
    rests_on_end_velocity,
)
from tracerisk.ros.robot.trajectories.settings import TrajectorySettings
from tracerisk.ros.robot.trajectories.timed import WRAPAROUND, timed
from tracerisk.ros.robot.trajectory_messages import TrajectoryCode, TrajectoryRefusedError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.motion.execution import Motion
    from tracerisk.twin.physics.motion import JointTrajectory
    from tracerisk.twin.simulation.twin import Twin

_FOR_GRIPPERS = "ripper"
_STREAMED_S = 0.1
_BEYOND = 1.5  # times its limit: less is a matter of the curve between two points


class Pursued(Protocol):
    """A goal that a controller pursues."""

    def go_on_by(self, motion: Motion, trajectory: JointTrajectory) -> None:
        """See to the goal when a trajectory of a topic takes its joints."""


class TrajectoryController:
    """One controller: its parameters, and the goal that it pursues."""

    def __init__(self, runtime: Runtime, settings: TrajectorySettings) -> None:
        self.settings = settings
        self.pursuit: Pursued | None = None
        self._runtime = runtime
        self._twin: Twin = runtime.twin

    @property
    def joints(self) -> tuple[str, ...]:
        """Its joints; all of the arm where nothing says which they are."""
        return self.settings.joints or tuple(joint.name for joint in self._twin.robot.arm_joints)

    def taken_over(self, motion: Motion, trajectory: JointTrajectory) -> None:
        """Note that a trajectory of a topic has taken the joints of the goal, if there is one."""
        if self.pursuit is not None:
            self.pursuit.go_on_by(motion, trajectory)

    def asked(self, message: Any, now_ns: int) -> Asked:
        """Return a trajectory as it is asked of this controller.

        Raises:
            TrajectoryRefusedError: the robot lacks a joint that it names.
        """
        self._check_known(message.joint_names)
        return Asked(
            message,
            self.settings,
            *self._compared(tuple(message.joint_names)),
            self._runtime.distro,
            now_ns,
        )

    def check_joints(self, asked: Asked) -> None:
        """Raise TrajectoryRefusedError where the joints alone are a reason to refuse."""
        check_joints(asked)

    def trajectory(self, asked: Asked, stack: tuple[Frame, ...] | None) -> JointTrajectory:
        """Return what the twin follows of a trajectory.

        Raises:
            TrajectoryRefusedError: the controller takes none such.
        """
        self._note_rules(asked, stack)
        check(asked)
        made = timed(asked, self._twin)
        self._look_at_speeds(made, stack)
        return made

    def _look_at_speeds(self, made: JointTrajectory, stack: tuple[Frame, ...] | None) -> None:
        """Note a way between two points that a joint cannot follow in its time.

        A short trajectory, as a stream has them, is left out: the next one leads on.
        """
        robot = self._twin.robot
        if robot.approximate or made.duration_s < _STREAMED_S:
            return
        time, position = made.time, made.position
        if time[0] > 0.0:
            here = self._twin.joint_state().positions
            time = np.concatenate(([0.0], time))
            position = np.vstack(([here[name] for name in made.joints], position))
        steps, ways = np.diff(time), np.abs(np.diff(position, axis=0))
        if not steps.all():
            return
        speeds = ways / steps[:, None]
        limits = np.array([robot.joint(name).velocity_limit for name in made.joints])
        row, column = np.unravel_index(int((speeds / limits).argmax()), speeds.shape)
        speed, limit = float(speeds[row, column]), float(limits[column])
        if speed <= _BEYOND * limit:
            return
        joint, step, way = robot.joint(made.joints[column]), steps[row], ways[row, column]
        self._runtime.client(TwinCommands).report(
            "too_fast",
            f"the trajectory takes joint '{joint.name}' by {way:.3g} {joint.unit} in {step:.3g} s: "
            f"that is {speed:.3g} {joint.unit}/s, and its limit {limit:.3g} {joint.unit}/s; a real "
            "driver stops the arm or comes late",
            stack,
            object_name=joint.name,
        )

    def _note_rules(self, asked: Asked, stack: tuple[Frame, ...] | None) -> None:
        """Report which rules decide that the other distribution has otherwise."""
        distro, place = self._runtime.distro, _place(stack)
        if rests_on_end_velocity(asked):
            distro.decided(END_VELOCITY, place)
        if asked.settings.takes_effort and any(len(point.effort) for point in asked.points):
            distro.decided(EFFORT, place)
        here = self._twin.joint_state().positions
        for at, name in enumerate(asked.names):
            values = asked.points[0].positions
            turns = at < len(values) and abs(float(values[at]) - here[name]) > math.pi
            is_continuous = self._twin.robot.joint(name).type == "continuous"
            if turns and is_continuous and name not in asked.settings.wraps:
                distro.decided(WRAPAROUND, place)

    def _check_known(self, names: Iterable[str]) -> None:
        robot = self._twin.robot
        known = [joint.name for joint in robot.joints]
        for name in names:
            if name not in known:
                self._twin.on_unknown_joints(tuple(text for text in names if text))
                raise TrajectoryRefusedError(
                    f"robot '{robot.name}' has no joint '{name}'; {one_of(known, name)}",
                    TrajectoryCode.INVALID_JOINTS,
                )

    def _compared(self, names: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return which joints of the controller a message lacks, and which it has not.

        One finger stands for its gripper.
        """
        own, named = self.settings.joints, set(names)
        for gripper in self._twin.robot.grippers:
            if named & set(gripper.joints):
                named |= set(gripper.joints)
        if not own:
            return (), ()
        with_fingers = set(own)
        for gripper in self._twin.robot.grippers:
            if with_fingers & set(gripper.joints):
                with_fingers |= set(gripper.joints)
        missing = tuple(name for name in own if name not in named)
        return missing, tuple(name for name in names if name not in with_fingers)


class TrajectoryControllers:
    """The controllers by the namespace of what they serve: `runtime.client(...)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._made: dict[str, TrajectoryController] = {}

    def of(self, interface: str, joints: Iterable[str]) -> TrajectoryController:
        """Return the controller of an action or topic, for one that nothing describes by joints."""
        space = interface.rpartition("/")[0] or interface
        if space not in self._made:
            names = tuple(joints)
            made = TrajectoryController(self._runtime, self._settings(space, names))
            if not {joint.name for joint in self._runtime.twin.robot.joints}.issuperset(names):
                return made  # of a message that is refused nothing can be guessed
            if not made.settings.joints:
                return made
            self._made[space] = made
        return self._made[space]

    def _settings(self, space: str, joints: tuple[str, ...]) -> TrajectorySettings:
        for name, declared in robot_controllers(self._runtime).items():
            own = name.strip("/")
            if not f"/{space.strip('/')}".endswith(f"/{own}") or not declared.joints:
                continue
            if _FOR_GRIPPERS in declared.type:
                break
            values = declared.settings if "TrajectoryController" in declared.type else {}
            # Several bring-ups of a workspace may have one of this name: the message says which.
            named = frozenset(joints)
            asked = declared.of_joints(named.__eq__) or declared.of_joints(named.issubset)
            return TrajectorySettings.of((asked or declared).joints, values)
        return TrajectorySettings(self._guessed(joints))

    def _guessed(self, joints: tuple[str, ...]) -> tuple[str, ...]:
        """Return the joints of a controller that nothing describes, by those of its first message.

        They are these where they are those of known controllers, groups and grippers, or of a
        robot that is assumed itself; else the fewest that contain them.
        """
        robot, named = self._runtime.twin.robot, set(joints)
        known = [
            *(
                frozenset(robot_controller.joints)
                for robot_controller in robot_controllers(self._runtime).values()
            ),
            *(frozenset(group.joints) for group in robot.groups.values()),
            *(frozenset(gripper.joints) for gripper in robot.grippers),
            frozenset(joint.name for joint in robot.arm_joints),
        ]
        within = frozenset[str]().union(*(item for item in known if item <= named))
        beyond = sorted((item for item in known if item > named), key=len)
        if robot.assumes_names or within == named or not beyond:
            return tuple(dict.fromkeys(joints))
        return tuple(joint.name for joint in robot.joints if joint.name in beyond[0])


def _place(stack: tuple[Frame, ...] | None) -> Location | None:
    if not stack:
        return None
    line, column = stack[-1].site
    return Location(stack[-1].function.file, line, column or None)
