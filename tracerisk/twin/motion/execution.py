"""Carry out motions: the set-points of each step, and when a motion has ended.

A motion gives its set-points in advance, so that many steps can run at once; fingers that press
with little force, and whatever comes to rest, decide every few steps from what is measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.twin.motion.plausible_units import past_limits
from tracerisk.twin.physics.motion import (
    STEP_S,
    JointTrajectory,
    Leads,
    MotionOutcome,
    PlanningError,
)
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Joint

Array = NDArray[np.float64]
TimedWay = tuple[Array, Array, Array]
"""Times [s], positions and velocities, as `resample` takes them."""

GOAL_TOLERANCE = 0.005  # of a joint at the end of its motion [rad or m]
STOPPED_FRACTION = 0.01  # of the rated velocity: what counts as standing still
SETTLE_S = 1.0  # an arm that is not at its goal this long after the trajectory never will be
STALL_S = 0.1  # fingers that stand still this long short of their goal hold something
_LONGEST_S = 1800.0  # of a trajectory, whose set-points are all held in memory
LOOK_STEPS = 5  # between two looks at what is measured, where that decides


@dataclass(frozen=True, slots=True, order=True)
class Way:
    """How far something had to go, and still has to [rad or m]."""

    whole: float = 0.0
    """The length of the whole way, there and back counted twice."""
    left: float = 0.0
    """What is left of it."""

    @property
    def done(self) -> float:
        """The fraction that is done, from 0 to 1."""
        if self.whole <= 0.0:
            return 1.0
        return min(max(1.0 - self.left / self.whole, 0.0), 1.0)


@dataclass(eq=False, repr=False)
class Motion:
    """A motion that the twin carries out, as its owner sees it."""

    joints: tuple[str, ...]
    """The joints that it moves."""
    elements: tuple[str, ...]
    """The names addressed: arm joints, and grippers by their name."""
    started_ns: int
    """When it began, in simulated time [ns]."""
    goal: tuple[float, ...] = ()
    """Where it leads each of `elements` [rad or m]."""
    leads: Leads = "to_goal"
    """Where it leads: a velocity has no goal that it could miss."""
    speeds: tuple[float, ...] = ()
    """The velocity of each of `joints` that goes on until something stops it [rad/s or m/s]."""
    outcome: MotionOutcome = "active"
    """What it has come to."""
    ended_ns: int | None = None
    """When it ended [ns]; `None` while it goes on."""
    message: str = ""
    """Why it ended so, in words."""
    stalled: bool = False
    """Whether a gripper stopped on an object, short of the position asked for."""
    replaced_by: Motion | None = None
    """The motion that took its joints."""
    way: Way = Way()
    """The way of the joint that had the farthest to go; known when the motion has ended."""
    _open_parts: int = 0
    """The number of tracks that still carry out the motion."""

    def __repr__(self) -> str:
        return f"Motion({', '.join(self.elements)}: {self.outcome})"

    def begin_part(self) -> None:
        """Note that one more track carries out the motion; for the twin alone."""
        self._open_parts += 1

    def end_part(
        self,
        outcome: MotionOutcome,
        message: str,
        time_ns: int,
        way: Way,
        *,
        stalled: bool = False,
    ) -> None:
        """Note that one part ended; the motion ends with its last part, or the first failure."""
        self._open_parts -= 1
        self.way = max(self.way, way)
        if self.outcome != "active":
            return
        if message:
            self.message = f"{self.message}; {message}" if self.message else message
        self.stalled = self.stalled or stalled
        if outcome != "succeeded" or self._open_parts == 0:
            self.outcome = outcome
            self.ended_ns = time_ns


class Measured(Protocol):
    """What the simulation measures now, by the joints' places in the robot's order."""

    def position(self, joints: Sequence[int]) -> Array:
        """Return the positions of some joints [rad or m]."""

    def velocity(self, joints: Sequence[int]) -> Array:
        """Return the velocities of some joints [rad/s or m/s]."""

    def pressed(self) -> tuple[str, str] | None:
        """Return the link that something holds back hardest, and what it is; None: nothing."""


class Track(Protocol):
    """What drives some actuators for a while.

    `actuators` are the columns of the control that it sets, `joints` the rows it measures.
    """

    motion: Motion | None
    actuators: Sequence[int]
    joints: Sequence[int]

    def way(self, measured: Measured) -> Way:
        """Return the way of the joint that has the farthest to go."""

    def steps_ahead(self) -> int:
        """Return for how many steps the set-points are known, at least 1."""

    def fill(self, block: Array, measured: Measured) -> None:
        """Write the set-points of the next steps; block: (n, n_actuators), n <= steps ahead."""

    def finished(self, measured: Measured, time_ns: int) -> bool:
        """Return after these steps whether the track is over, having reported its motion."""


def servo_lead(joint: Joint) -> float:
    """Return the time by which a servo lags behind a moving set-point [s].

    A position servo with damping settles kv/kp of the speed behind; leading the set-point by as
    much cancels it.
    """
    return (joint.servo.damping + joint.servo.friction) / joint.servo.stiffness


@dataclass(frozen=True, slots=True)
class GoalTolerance:
    """When a trajectory's goal is reached."""

    position: float = GOAL_TOLERANCE
    """How far a joint may be from the goal, unless in `of_joints` [rad or m]."""
    settle_s: float = SETTLE_S
    """The longest wait for the goal after the end of the trajectory [s]; may be infinite."""
    of_joints: Mapping[str, float] = field(default_factory=dict)
    """How far single joints may be from the goal [rad or m]."""
    speed: float | None = None
    """How fast a joint may still be [rad/s or m/s]; `None` means standing still."""

    def of(self, joint: str) -> float:
        """Return how far a joint may be from the goal [rad or m]."""
        return self.of_joints.get(joint, self.position)


@dataclass
class ArmTrack:
    """Set-points of arm joints along a trajectory, then the wait until they are reached."""

    motion: Motion | None
    """The motion that the track is part of; `None` while the arm brakes."""
    actuators: Sequence[int]
    """The index of each joint's actuator in the controls, (n_joints,)."""
    joints: Sequence[int]
    """The index of each joint in the robot's order, (n_joints,)."""
    members: Sequence[Joint]
    """The joints, (n_joints,)."""
    position: Array
    """The set-point of each step [rad or m], (n_steps, n_joints)."""
    velocity: Array
    """The velocity of the set-points [rad/s or m/s], (n_steps, n_joints)."""
    begin: Array
    """The measured positions when the track begins [rad or m], (n_joints,)."""
    goal: GoalTolerance = field(default_factory=GoalTolerance)
    """When the last set-point counts as reached."""
    _at: int = field(default=0, init=False)
    """The number of set-points applied."""
    _waited: int = field(default=0, init=False)
    """The number of steps waited since the last set-point."""

    def __post_init__(self) -> None:
        lead = np.array([servo_lead(joint) for joint in self.members])
        self._control = self.position + self.velocity * lead
        self._still = np.array([joint.velocity_limit for joint in self.members]) * STOPPED_FRACTION

    def brake(self) -> ArmTrack:
        """Return the track that brings the moving set-points to rest at rated acceleration."""
        position, velocity = self.reference()
        rated = np.array([joint.acceleration_limit for joint in self.members])
        stop = np.abs(velocity) / rated
        n_steps = max(1, math.ceil(float(stop.max(initial=0.0)) / STEP_S))
        t = np.minimum(np.arange(1, n_steps + 1)[:, None] * STEP_S, stop)
        slowing = np.sign(velocity) * rated
        way = position + velocity * t - slowing * t * t / 2
        return replace(self, motion=None, position=way, velocity=velocity - slowing * t)

    def without(self, actuators: set[int]) -> ArmTrack | None:
        """Return what is left of the track without some actuators, `None` for nothing."""
        kept = [i for i, actuator in enumerate(self.actuators) if actuator not in actuators]
        if len(kept) == len(self.actuators):
            return self
        if not kept:
            return None
        track = replace(
            self,
            actuators=[self.actuators[i] for i in kept],
            joints=[self.joints[i] for i in kept],
            members=[self.members[i] for i in kept],
            position=self.position[:, kept],
            velocity=self.velocity[:, kept],
            begin=self.begin[kept],
        )
        track._at, track._waited = self._at, self._waited
        return track

    def reference(self) -> tuple[Array, Array]:
        """Return the last set-points, (n_joints,), and their velocities."""
        at = min(max(self._at, 1), len(self.position)) - 1
        if self._at >= len(self.position):
            return self.position[-1], np.zeros(len(self.members))
        return self.position[at], self.velocity[at]

    def ahead(self, n_steps: int) -> tuple[Array, Array]:
        """Return the next set-points and their velocities, each (n_steps, n_joints)."""
        at = np.arange(self._at, self._at + n_steps)
        kept = np.minimum(at, len(self.position) - 1)
        velocity = self.velocity[kept]
        velocity[at >= len(self.position)] = 0.0
        return self.position[kept], velocity

    def way(self, measured: Measured) -> Way:
        """Return the way of the joint that has the farthest to go along the set-points."""
        if self.motion is not None and self.motion.leads != "to_goal":
            return Way()
        steps = np.abs(np.diff(self.position, axis=0, prepend=self.begin[None, :]))
        ways = steps.sum(axis=0)
        farthest = int(np.argmax(ways))
        lag = self.begin if self._at == 0 else self.position[min(self._at, len(steps)) - 1]
        here = float(measured.position([self.joints[farthest]])[0])
        ahead = float(steps[self._at :, farthest].sum())
        return Way(float(ways[farthest]), ahead + abs(here - float(lag[farthest])))

    def steps_ahead(self) -> int:
        """Return how many set-points are left; a few while the arm settles."""
        left = len(self.position) - self._at
        return left if left > 0 else LOOK_STEPS

    def fill(self, block: Array, measured: Measured) -> None:  # noqa: ARG002 (the protocol's)
        """Write the set-points of the next steps, the last again when there are no more."""
        left = len(self.position) - self._at
        if left > 0:
            block[:, self.actuators] = self._control[self._at : self._at + len(block)]
            self._at += len(block)
        else:
            block[:, self.actuators] = self.position[-1]
            self._waited += len(block)

    def finished(self, measured: Measured, time_ns: int) -> bool:
        """Return whether the arm stands still at its goal, or will not any more."""
        if self._at < len(self.position):
            return False
        if self.motion is None:
            return True
        miss = np.abs(measured.position(self.joints) - self.position[-1])
        speed = np.abs(measured.velocity(self.joints))
        tolerance = np.array([self.goal.of(joint.name) for joint in self.members])
        still = self._still if self.goal.speed is None else self.goal.speed
        if (miss <= tolerance).all() and (speed <= still).all():
            self.motion.end_part("succeeded", "", time_ns, self.way(measured))
            return True
        if self._waited * STEP_S < self.goal.settle_s:
            return False
        worst = int(np.argmax(miss / tolerance))
        text = (
            f"joint '{self.members[worst].name}' is {miss[worst]:.4f} from its goal "
            f"{self.goal.settle_s:g} s after the trajectory ended (tolerance {tolerance[worst]:g})"
        )
        past = past_limits(self.members[worst], float(self.position[-1][worst]), 0.0)
        if past:
            text += f"; its goal is {past}"
        pressed = measured.pressed()
        if pressed is not None:
            text += f"; '{pressed[0]}' presses on '{pressed[1]}'"
        self.motion.end_part("aborted", text, time_ns, self.way(measured))
        return True


def check_trajectory(trajectory: JointTrajectory, robot: Robot) -> None:
    """Raise PlanningError("bad_request") for what no controller would follow."""
    refusal = _refusal(trajectory, robot)
    if refusal is not None:
        raise PlanningError("bad_request", refusal)


def _refusal(trajectory: JointTrajectory, robot: Robot) -> str | None:
    joints = [joint.name for joint in robot.joints]
    shape = (len(trajectory.time), len(trajectory.joints))
    if not shape[0] or not shape[1]:
        return "the trajectory has no points or no joints"
    for name in trajectory.joints:
        if name not in joints:
            return f"robot '{robot.name}' has no joint '{name}'; {one_of(joints, name)}"
    if len(set(trajectory.joints)) != shape[1]:
        return "the trajectory names a joint twice"
    if trajectory.position.shape != shape or trajectory.velocity.shape != shape:
        return f"positions and velocities must be {shape[0]} points of {shape[1]} joints"
    arrays = (trajectory.time, trajectory.position, trajectory.velocity)
    if not all(np.isfinite(array).all() for array in arrays):
        return "the trajectory holds a number that is not finite"
    if trajectory.time[-1] > _LONGEST_S:
        return (
            f"the trajectory lasts {trajectory.time[-1]:g} s; at most {_LONGEST_S:g} s are followed"
        )
    if trajectory.time[0] < 0.0 or not (np.diff(trajectory.time) > 0.0).all():
        return "the times of a trajectory must rise from point to point, from 0 on"
    return None
