"""The queue of motions in the controller of a Dobot arm, and the words of its commands.

Source: Dobot-Arm/DOBOT_6Axis_ROS2_V4, dobot_bringup_v4 and the list of TCP commands V4 there: [mm],
[deg], shares of the greatest speed in percent.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.transforms.poses import quaternion_from_rpy, rpy_from_quaternion
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame

DISABLED, IDLE, RUNNING, ERROR, COLLISION = 4, 5, 7, 9, 11
"""What RobotMode returns."""
OK, NOT_EXECUTED, IN_ERROR, STOPPED, POWERED_OFF = 0, -1, -2, -3, -4
"""What a command returns."""
WRONG_TYPE, OUT_OF_RANGE = -30001, -40001

_FASTEST_M_S = 2.0  # of the tool; Dobot CR5 user guide
_WORDS = frozenset(
    {"a", "v", "cp", "r", "speed", "user", "tool", "t", "aheadtime", "gain", "coordtype"}
)

Make = Callable[[], JointTrajectory | None]


class DobotQueue:
    """Carries out motions one after the other; what cannot be followed sets an error."""

    def __init__(self, arm: ArmMotion, commands: TwinCommands) -> None:
        self.arm = arm
        self._commands = commands
        self._waiting: deque[tuple[str, tuple[Frame, ...], Make]] = deque()
        self._motion: Motion | None = None
        self.is_enabled = True
        self.is_stopped = False
        self.error = 0
        self.number = 0
        self.done = 0
        self.share = {"factor": 1.0, "joint": 1.0, "line": 1.0}

    @property
    def mode(self) -> int:
        """The state, as RobotMode returns it."""
        if self.error:
            return self.error
        if not self.is_enabled:
            return DISABLED
        return RUNNING if self._waiting or self._motion is not None else IDLE

    def refused(self) -> int:
        """Return why nothing would move now, 0 where it would."""
        if self.is_stopped:
            return STOPPED
        if self.error:
            return IN_ERROR
        return OK if self.is_enabled else POWERED_OFF

    def add(self, kind: str, make: Make) -> int:
        """Put a motion at the end of the queue; `make` is called at its turn."""
        code, stack = self.refused(), self._commands.stack()
        if code:
            return self.report_refused(kind, code)
        self.number += 1
        self._waiting.append((kind, stack, make))
        if self._motion is None:
            self._next()
        return OK

    def report_refused(self, kind: str, code: int) -> int:
        """Record that a command moved nothing, and return its code."""
        self._commands.report("command_ignored", f"{kind} moved nothing: it returned {code}")
        return code

    def clear(self) -> None:
        """Forget what waits and what goes on: something else takes the joints."""
        self._drop("another took its place")
        self._motion = None

    def at_once(self, kind: str, make: Make) -> int:
        """Begin a motion now, in the place of the one that goes on."""
        self.clear()
        return self.add(kind, make)

    def stop(self) -> None:
        """Drop all that waits and bring the arm to rest."""
        while self._waiting:
            kind, stack, _ = self._waiting.popleft()
            self._commands.refuse(kind, stack, "cancelled")
        self.arm.stop()
        self._motion = None

    def _drop(self, reason: str) -> None:
        """Forget what waits, which never begins."""
        while self._waiting:
            kind, stack, _ = self._waiting.popleft()
            self._commands.report("command_ignored", f"{kind} moved nothing: {reason}", stack)

    def _next(self) -> None:
        self._motion = None
        while self._waiting and self._motion is None:
            kind, stack, make = self._waiting.popleft()
            try:
                trajectory = make()
            except PlanningError as error:
                self._commands.report(
                    "command_ignored", f"{kind} moved nothing: {error.message}", stack
                )
                self.error = ERROR
                self._drop("an error dropped what waited")
                return
            if trajectory is None:
                self.done += 1
                continue
            motion = self.arm.twin.follow(trajectory)
            self._motion = motion
            self._commands.begin(
                f"dobot_{kind}",
                motion,
                stack,
                self._ended,
                what=kind,
            )

    def _ended(self, motion: Motion) -> None:
        if motion is not self._motion:
            return
        self.done += 1
        if motion.outcome == "aborted":
            self.error = COLLISION
            self._drop("an error dropped what waited")
        self._next()

    # Trajectories

    def joint_move(self, degrees: Sequence[float], words: Mapping[str, float]) -> JointTrajectory:
        """Return the move of all joints to [deg]."""
        goal = [math.radians(degree) for degree in degrees]
        share = self.share["factor"] * words.get("v", 100 * self.share["joint"]) / 100
        rise = words.get("a", 100.0) / 100
        return self.arm.to_joints(
            goal,
            speeds=[joint.velocity_limit * share for joint in self.arm.arm],
            rises=[joint.acceleration_limit * rise for joint in self.arm.arm],
        )

    def pose_move(self, pose: Pose, words: Mapping[str, float]) -> JointTrajectory:
        """Return the move of all joints to where the tool is at a pose."""
        return self.joint_move([math.degrees(v) for v in self.arm.reach(pose)], words)

    def line(self, poses: Sequence[Pose], words: Mapping[str, float]) -> JointTrajectory:
        """Return the way of the tool along straight lines."""
        share = self.share["factor"] * words.get("v", 100 * self.share["line"]) / 100
        speed = share * _FASTEST_M_S
        if "speed" in words:
            speed = self.share["factor"] * words["speed"] / 1000
        return self.arm.line(poses, speed=speed)


def words_of(given: Sequence[str]) -> dict[str, float]:
    """Return the parameters of a command: `v=50`, `a=20`.

    Raises:
        PlanningError: one is not of this form, unknown, or asks for a frame that is not there.
    """
    words: dict[str, float] = {}
    for part in (piece for text in given for piece in text.split(",")):
        name, _, value = (piece.strip() for piece in part.partition("="))
        if not name:
            continue
        if name.lower() not in _WORDS:
            raise PlanningError("bad_request", f"parameter '{part}'; allowed: {sorted(_WORDS)}")
        try:
            words[name.lower()] = float(value)
        except ValueError as error:
            raise PlanningError("bad_request", f"parameter '{part}' has no number") from error
    for name in ("user", "tool"):
        if words.get(name):
            raise PlanningError(
                "bad_request", f"{name} frame {words[name]:g} is not simulated; allowed: 0"
            )
    for name in ("v", "a"):
        if not 1 <= words.get(name, 1) <= 100:
            raise PlanningError("bad_request", f"{name}={words[name]:g}; allowed: 1 to 100 %")
    return words


def pose_of(values: Sequence[float]) -> Pose:
    """Return the pose of x, y, z [mm], rx, ry, rz [deg]."""
    x, y, z, *turns = (float(value) for value in values[:6])
    rx, ry, rz = (math.radians(turn) for turn in turns)
    return Pose((x / 1000, y / 1000, z / 1000), quaternion_from_rpy(rx, ry, rz))


def values_of(pose: Pose) -> list[float]:
    """Return x, y, z [mm], rx, ry, rz [deg] of a pose."""
    turns = (math.degrees(value) for value in rpy_from_quaternion(pose.orientation))
    return [*(1000 * value for value in pose.position), *turns]
