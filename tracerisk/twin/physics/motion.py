"""What a controller can ask the arm to do, and what becomes of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import triple
from tracerisk.errors import TraceRiskError

STEP_NS = 2_000_000
"""The step of the simulation [ns]."""
STEP_S = STEP_NS * 1e-9
"""The same [s]."""

MotionOutcome = Literal["active", "succeeded", "aborted", "preempted"]
Leads = Literal[
    "to_goal",  # to its last point, where it is to be
    "for_a_while",  # at a velocity, which ends by itself when no other follows
    "on",  # at a velocity, until something stops it
]
"""Where a trajectory leads: a velocity has no goal that it could miss."""
PlanningFailure = Literal[
    "invalid_goal",
    "no_ik_solution",
    "no_plan",
    "collision",
    "start_in_collision",
    "bad_request",
    "wrong_count",
]


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose in the robot's base frame, or in the frame that its owner names."""

    position: tuple[float, float, float]
    """The position (x, y, z) [m]."""
    orientation: tuple[float, float, float, float]
    """The unit quaternion (x, y, z, w)."""

    @classmethod
    def of(cls, position: Iterable[float], turn: Iterable[float]) -> Pose:
        """Return a pose as MuJoCo has it: `turn` is the quaternion (w, x, y, z)."""
        w, x, y, z = (float(value) for value in turn)
        return cls(triple(position), (x, y, z, w))


@dataclass(frozen=True, slots=True)
class LinkTarget:
    """Where a link should come."""

    link: str
    """The name of the link."""
    pose: Pose
    """The wanted pose in the robot's base frame."""
    position_tolerance: float = 1e-4
    """The greatest distance that counts as reached [m]."""
    orientation_tolerance: float = 1e-3
    """The greatest turn that counts as reached [rad]; infinite for any turn."""


@dataclass(frozen=True, slots=True)
class JointState:
    """The measured state of named joints; every tuple but `absent` is (n_joints,)."""

    names: tuple[str, ...]
    """The joint names, in the order of the other fields."""
    position: tuple[float, ...]
    """The positions [rad or m]."""
    velocity: tuple[float, ...]
    """The velocities [rad/s or m/s]."""
    effort: tuple[float, ...]
    """The efforts [N m or N]."""
    absent: frozenset[str] = frozenset()
    """The joints that are not measured; their values are the last measured ones."""

    @property
    def positions(self) -> dict[str, float]:
        """The position of each joint by its name."""
        return dict(zip(self.names, self.position, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class JointTrajectory:
    """A path of named joints in time."""

    joints: tuple[str, ...]
    """The joints that it moves."""
    time: NDArray[np.float64]
    """(n_points,) from the start, rising, the first 0 [s]."""
    position: NDArray[np.float64]
    """(n_points, n_joints) [rad or m]."""
    velocity: NDArray[np.float64]
    """(n_points, n_joints) [rad/s or m/s]."""
    leads: Leads = "to_goal"
    """Where it leads."""
    degree: NDArray[np.int8] | None = None
    """(n_points,) of the polynomial that leads to each point: 0 waits at the point before, 1 is
    straight, 3 has the velocities of both ends, 5 the accelerations too; `None` is 3 throughout."""
    acceleration: NDArray[np.float64] | None = None
    """(n_points, n_joints) where a degree is 5 [rad/s^2 or m/s^2]; `None` is 0 throughout."""

    @property
    def duration_s(self) -> float:
        """The time from the first to the last point [s]."""
        return float(self.time[-1]) if len(self.time) else 0.0

    def led_in(
        self, position: NDArray[np.float64], velocity: NDArray[np.float64]
    ) -> JointTrajectory:
        """Return it begun at time 0 from a position with a velocity, each (n_joints,).

        One that begins at time 0 is left as it is.
        """
        if self.time[0] <= 0.0:
            return self

        def begun(first: NDArray[np.float64], rest: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.vstack((first, rest))

        degree, acceleration = self.degree, self.acceleration
        return replace(
            self,
            time=np.concatenate(([0.0], self.time)),
            position=begun(position, self.position),
            velocity=begun(velocity, self.velocity),
            degree=None if degree is None else np.concatenate((degree[:1], degree)),
            acceleration=None
            if acceleration is None
            else begun(np.zeros(len(position)), acceleration),
        )


class PlanningError(TraceRiskError, RuntimeError):
    """No motion was found; the controller gets it as from MoveIt, and the run goes on."""

    def __init__(self, failure: PlanningFailure, message: str) -> None:
        super().__init__(message)
        self.failure = failure
