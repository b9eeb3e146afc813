"""The queue of motions in the controller box of an xArm: one after the other, at their speeds.

Source of units, defaults and codes: xArm-Developer/xArm-Python-SDK (doc/api) and xarm_ros2
(xarm_api/srv): [mm], [rad], speeds of 100 mm/s and 0.349 rad/s where none is given.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.ros.motion_profiles import Ramp, ramp_of_speed, ramped
from tracerisk.ros.poses import compose, multiply, quaternion_from_rpy, rpy_from_quaternion
from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.velocity_motion import at_velocities
from tracerisk.twin.execution import Motion
from tracerisk.twin.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame

READY, STOPPED = 2, 4
"""States: 1 moving, 2 ready, 3 paused, 4 stopped."""
ERROR_SET, NOT_READY = 1, 9
"""What a call returns that moves nothing: an error is not cleaned, or the state is not ready."""
NO_WAY = 21
"""The error of the box for a pose that no joint positions lead to."""
COLLISION = 31
"""The error of the box for a motor whose current says that something is in the way."""

_JOINT_SPEED, _JOINT_RISE = 0.3491, 8.727
_LINE_SPEED = 100.0
_FLANGES = ("link_eef", "link_tcp")


class PoseError(ValueError):
    """A pose that is not one: x, y, z, roll, pitch and yaw are expected."""


@dataclass(frozen=True, slots=True)
class Waiting:
    """A motion that was asked for, by the stack that asked."""

    kind: str
    stack: tuple[Frame, ...]
    joints: tuple[float, ...] | None = None
    pose: Pose | None = None
    speed: float = 0.0
    acceleration: float = 0.0


class XarmMotion:
    """Carries out motions in the order in which they come; an error drops all that wait."""

    def __init__(self, commands: TwinCommands) -> None:
        self._commands = commands
        self._twin = commands.twin
        robot = self._twin.robot
        self.joints = tuple(joint.name for joint in robot.arm_joints)
        self._group = next(
            (name for name, group in robot.groups.items() if set(group.joints) == set(self.joints)),
            None,
        )
        self.flange = next(
            (link for link in _FLANGES if link in robot.link_names),
            robot.groups[self._group].tip_link if self._group else None,
        )
        self._queue: deque[Waiting] = deque()
        self._motion: Motion | None = None
        self.mode = 0
        self.state = READY
        self.error = 0

    @property
    def is_busy(self) -> bool:
        """Whether a motion goes on or waits."""
        return bool(self._queue) or self._motion is not None

    def refused(self) -> int:
        """Return why nothing would move now, 0 where it would."""
        if self.error:
            return ERROR_SET
        return NOT_READY if self.state == STOPPED else 0

    def ask(self, waiting: Waiting) -> int:
        """Queue a motion and return 0, or why it is not taken."""
        code = self.refused()
        if code:
            self._tell(waiting, f"the arm is not ready (state {self.state}, error {self.error})")
            return code
        self._queue.append(waiting)
        if self._motion is None:
            self._next()
        return self.refused()

    def stop(self) -> None:
        """Drop what waits and bring the joints to rest."""
        self._queue.clear()
        self._twin.stop(self.joints)
        self._commands.poll()
        self._motion = None

    def at_speeds(self, speeds: Sequence[float], for_s: float | None, kind: str) -> int:
        """Move the joints at velocities [rad/s], until told otherwise or for a time."""
        stack = self._commands.stack()
        code = self.refused()
        if code:
            return code
        asked = dict(zip(self.joints, speeds, strict=False))
        trajectory = at_velocities(self._twin, asked, for_s)
        if trajectory is None:
            self.stop()
        else:
            self._commands.begin(kind, self._twin.follow(trajectory), stack)
        return 0

    def positions(self) -> list[float]:
        """Return where the joints are [rad]."""
        state = self._twin.joint_state()
        at = dict(zip(state.names, state.position, strict=True))
        return [at[name] for name in self.joints]

    def flange_pose(self) -> list[float]:
        """Return where the flange is: x, y, z [mm], roll, pitch, yaw [rad]."""
        if self.flange is None:
            return [0.0] * 6
        pose = self._twin.link_pose(self.flange)
        return [*(1000 * each for each in pose.position), *rpy_from_quaternion(pose.orientation)]

    def relative(self, pose: Pose, *, in_tool: bool) -> Pose:
        """Return a pose that is given from where the flange will be when the queue is done."""
        last = next((each.pose for each in reversed(self._queue) if each.pose is not None), None)
        here = last or self._twin.link_pose(self.flange or self._twin.robot.base_link)
        if in_tool:
            return compose(here, pose)
        x, y, z = (a + b for a, b in zip(here.position, pose.position, strict=True))
        return Pose((x, y, z), multiply(pose.orientation, here.orientation))

    def _next(self) -> None:
        self._motion = None
        while self._queue and self._motion is None:
            waiting = self._queue.popleft()
            try:
                motion = self._twin.follow(self._trajectory(waiting))
            except PlanningError as error:
                self.error, self.state = NO_WAY, STOPPED
                self._queue.clear()
                self._tell(waiting, error.message)
                return
            self._motion = motion
            self._commands.begin(
                waiting.kind,
                motion,
                waiting.stack,
                lambda ended, waiting=waiting: self._ended(ended, waiting),  # type: ignore[misc]
            )

    def _ended(self, motion: Motion, waiting: Waiting) -> None:
        if motion.outcome == "aborted":
            self.error, self.state = COLLISION, STOPPED
            self._queue.clear()
            self._commands.tell(
                "execution_failure", f"{waiting.kind} was aborted: {motion.message}", waiting.stack
            )
        if motion is self._motion:
            self._next()

    def _trajectory(self, waiting: Waiting) -> JointTrajectory:
        if waiting.joints is not None:
            speed = waiting.speed or _JOINT_SPEED
            rise = waiting.acceleration or _JOINT_RISE
            here = self.positions()
            goal = [*waiting.joints[: len(here)], *here[len(waiting.joints) :]]
            for name, value in zip(self.joints, goal, strict=True):
                joint = self._twin.robot.joint(name)
                if not joint.lower - 1e-3 <= value <= joint.upper + 1e-3:
                    raise PlanningError(
                        "invalid_goal",
                        f"{value:.3f} for '{name}' is outside "
                        f"[{joint.lower:.3f}, {joint.upper:.3f}]",
                    )
            way = max(abs(b - a) for a, b in zip(here, goal, strict=True))
            ramp: Ramp = ramp_of_speed(max(way, 1e-6), speed, rise)
            return ramped(self.joints, here, goal, [ramp] * len(here))
        return self._line(waiting)

    def _line(self, waiting: Waiting) -> JointTrajectory:
        if self._group is None or self.flange is None or waiting.pose is None:
            raise PlanningError("bad_request", "the robot has no planning group of all its joints")
        here = self._twin.link_pose(self.flange)
        trajectory, fraction = self._twin.plan_cartesian(
            self._group,
            [waiting.pose],
            link=self.flange,
            avoid_collisions=False,
            velocity_scaling=1.0,
            acceleration_scaling=1.0,
        )
        if fraction < 1.0 - 1e-6:
            x, y, z = waiting.pose.position
            raise PlanningError(
                "no_ik_solution",
                f"only {fraction:.0%} of the line to ({x:.3f}, {y:.3f}, {z:.3f}) m can be followed",
            )
        way = 1000 * float(np.linalg.norm(np.subtract(waiting.pose.position, here.position)))
        asked = way / (waiting.speed or _LINE_SPEED)
        slower = max(1.0, asked / max(trajectory.duration_s, 1e-6))
        return JointTrajectory(
            trajectory.joints,
            trajectory.time * slower,
            trajectory.position,
            trajectory.velocity / slower,
        )

    def _tell(self, waiting: Waiting, message: str) -> None:
        self._commands.tell(
            "command_ignored", f"{waiting.kind} moved nothing: {message}", waiting.stack
        )


def pose_of(values: Sequence[float]) -> Pose:
    """Return the pose of x, y, z [mm], roll, pitch, yaw [rad]; raise PoseError for fewer."""
    if len(values) < 6:
        raise PoseError(f"a pose has 6 values, not {len(values)}")
    x, y, z, roll, pitch, yaw = (float(value) for value in values[:6])
    return Pose((x / 1000, y / 1000, z / 1000), quaternion_from_rpy(roll, pitch, yaw))
