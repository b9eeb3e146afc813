"""How near its path and its goal an arm must be: of a goal's message, and of its controller."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.messages.dialect import nanoseconds
from tracerisk.ros.robot.trajectories.settings import TrajectorySettings
from tracerisk.twin.motion.execution import GOAL_TOLERANCE, SETTLE_S, GoalTolerance

TOLERANCES = "trajectory-tolerances"
GOAL_TIME = "trajectory-goal-time-0"

_NO_TOLERANCE = 1e9
_ERASED = -1.0
_IS_ERASED = 1e-6  # how far from -1 a value may be that erases
# Where a goal gives a time only: what drivers commonly allow. `goal: 0.1` in
# UniversalRobots/Universal_Robots_ROS2_Driver, ur_robot_driver/config/ur_controllers.yaml.
LATE = 0.1  # [rad or m]


class _IllegalToleranceError(Exception):
    """A tolerance that voids all those of its goal."""


@dataclass(frozen=True, slots=True)
class GoalLimits:
    """The limits of one goal; a joint without one may be anywhere on the way.

    Where neither goal nor controller gives one, the goal is what the twin counts as reached.
    """

    path: Mapping[str, float] = field(default_factory=dict)
    """How far a joint may be from its path [rad or m]."""
    path_speed: Mapping[str, float] = field(default_factory=dict)
    """By how much its velocity may differ [rad/s or m/s]."""
    goal: Mapping[str, float] = field(default_factory=dict)
    """How far it may be from its goal [rad or m]; of a tolerance that is taken away, infinite."""
    time_s: float = 0.0
    """How long after the end of the trajectory the goal may be reached [s]; 0: see `waits`."""
    waits: bool = True
    """Whether a time of 0 is without end; otherwise the goal is to be reached at the end."""
    speed: float | None = None
    """How fast a joint may be at its goal [rad/s or m/s]; `None` is standing still."""

    @property
    def has_goal(self) -> bool:
        """Whether a positive tolerance of the goal was given."""
        return any(map(math.isfinite, self.goal.values()))

    @property
    def tolerance(self) -> GoalTolerance:
        """What the twin waits for: it gives up no sooner than the controller does."""
        of_joints = {name: min(limit, _NO_TOLERANCE) for name, limit in self.goal.items()}
        if not self.has_goal:
            settle_s = max(self.time_s, SETTLE_S)
            return GoalTolerance(GOAL_TOLERANCE, settle_s, of_joints)
        if self.time_s == 0.0 and not self.waits:
            # Each joint is looked at once when the trajectory ends.
            return GoalTolerance(LATE, 0.0, of_joints, self.speed or math.inf)
        settle_s = self.time_s if self.time_s > 0.0 else math.inf
        return GoalTolerance(LATE, settle_s, of_joints, self.speed)

    def of_joint(self, name: str) -> float:
        """Return how far a joint may be from its goal when its time is over [rad or m]."""
        return self.goal.get(name, LATE)


def goal_limits(
    asked: Any, settings: TrajectorySettings, joints: Iterable[str], rules: DistroRules
) -> GoalLimits:
    """Return the limits of a FollowJointTrajectory goal for its controller.

    A positive value counts, 0 leaves that of the controller. A negative one takes it away in ROS 1;
    in ROS 2 only -1 does, and another one, or a joint that the controller has not, leaves all
    of the goal's unused.
    """
    own = GoalLimits(
        dict(settings.path),
        {},
        dict(settings.goal),
        settings.goal_time_s,
        waits=rules.value(GOAL_TIME) == "waits without end",
        speed=settings.stopped_velocity if settings.is_declared else None,
    )
    known = set(settings.joints or joints)
    is_strict = rules.value(TOLERANCES) == "-1 takes away, others void"
    knows_velocity = settings.knows_velocity or not is_strict
    try:
        time_s = _resolved(
            own.time_s, nanoseconds(asked.goal_time_tolerance) * 1e-9, 0.0, is_strict
        )
        path, speed, goal = dict(own.path), dict(own.path_speed), dict(own.goal)
        for entry in asked.path_tolerance:
            if _is_known(entry.name, known, is_strict):
                _set(path, entry.name, entry.position, is_strict)
                if knows_velocity:
                    _set(speed, entry.name, entry.velocity, is_strict)
        for entry in asked.goal_tolerance:
            if _is_known(entry.name, known, is_strict):
                _set(goal, entry.name, entry.position, is_strict, erased=math.inf)
    except _IllegalToleranceError:
        return own
    return replace(own, path=path, path_speed=speed, goal=goal, time_s=time_s)


def _is_known(name: str, known: set[str], is_strict: bool) -> bool:
    if name in known:
        return True
    if is_strict:
        raise _IllegalToleranceError
    return False


def _set(
    limits: dict[str, float],
    name: str,
    given: float,
    is_strict: bool,
    *,
    erased: float | None = None,
) -> None:
    value = _resolved(limits.get(name), given, erased, is_strict)
    if value is None:
        limits.pop(name, None)
    else:
        limits[name] = value


def _resolved(default: Any, given: float, erased: Any, is_strict: bool) -> Any:
    if given > 0.0:
        return given
    if given == 0.0:
        return default
    if is_strict and abs(given - _ERASED) > _IS_ERASED:
        raise _IllegalToleranceError
    return erased
