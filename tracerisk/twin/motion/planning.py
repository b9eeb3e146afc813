"""Plan motions of a group: in joint space, to a pose, or straight in space.

A move in joint space is straight where that is free, else it leads around what is declared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import one_of
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.kinematics import Bounds, Kinematics, turned_near
from tracerisk.twin.motion.plausible_units import shown_limits
from tracerisk.twin.motion.straight_lines import straight_steps
from tracerisk.twin.motion.timing import (
    MIN_ANGLE_CHANGE,
    PATH_TOLERANCE,
    RESAMPLE_S,
    along_free_path,
)
from tracerisk.twin.physics.motion import JointTrajectory, LinkTarget, PlanningError, Pose
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Joint, Scaling

_LIMIT_SLACK = 1e-6  # a target this far past a limit is a rounding error [rad or m]
_JUMP = 0.8  # a joint that turns further between them has changed branch [rad]
_LEAVING = 0.5 * math.pi  # how far one may turn to leave the singularity in which a path begins
_OTHER = 0.2  # another posture differs more than this in a joint [rad or m]
_FLIPPED = 3.3  # and at most this, where an arm has another branch [rad or m]
_ELBOW = 0.5  # or this, where an arm has joints to spare and turns its elbow [rad or m]
_SPARE = 6  # joints that a pose takes
_MOST_PASSED = 16  # solutions alike that are passed over for another
_NUDGES = (0.1, -0.1, 0.3, -0.3)  # by which a joint is moved off a singularity [rad or m]
_Reached = tuple[float, NDArray[np.float64]]  # the furthest move of a joint [rad or m], and where


@dataclass(eq=False)
class Planner:
    """Plans on the robot's kinematics, clear of itself and of what the clearance has declared."""

    _robot: Robot
    """The robot with its joint limits and groups."""
    _kinematics: Kinematics
    """Forward and inverse kinematics of the robot."""
    _clearance: Clearance
    """The check for collisions and path constraints."""
    _begin: Callable[[Mapping[str, float]], dict[str, float]] = dict
    """Completes a start with the positions of the joints that it leaves out [rad or m]."""
    takes_other: bool = False
    """Whether another posture than the nearest is tried first, where there is one."""

    def joints(
        self,
        group: str,
        target: Mapping[str, float],
        start: Mapping[str, float] | None = None,
        *,
        scaling: Scaling | None = None,
    ) -> JointTrajectory:
        """Return the move of `group` from `start` to `target`, straight and synchronised if free.

        Joints of the group that `target` leaves out stay where `start` has them, but fingers that
        follow one that it names.
        Raises PlanningError("invalid_goal") for a joint outside the group or its limits,
        ("collision") for a goal that touches something, ("start_in_collision") and ("no_plan").
        """
        return self.to_one_of(group, [target], start, scaling=scaling)

    def to_one_of(
        self,
        group: str,
        targets: Iterable[Mapping[str, float]],
        start: Mapping[str, float] | None = None,
        *,
        scaling: Scaling | None = None,
    ) -> JointTrajectory:
        """Return the move of `group` to the first of `targets` that is come to, as `joints`.

        It is straight to the first to which that is free, else it leads around what is declared to
        any of them. Raises PlanningError as `joints` does, of the first target.
        """
        start = self._begin(start or {})
        members = self._members(group)
        names = tuple(joint.name for joint in members)
        begin = np.array([start[name] for name in names])
        goals = (self._goal(group, members, target, start) for target in targets)
        path = self._clearance.way(members, start, begin, goals)
        is_free = self._clearance.judge(members, start)
        return JointTrajectory(
            names, *along_free_path(path, *self._limits(members, scaling), is_free)
        )

    def _goal(
        self,
        group: str,
        members: Sequence[Joint],
        target: Mapping[str, float],
        start: Mapping[str, float],
    ) -> NDArray[np.float64]:
        names = [joint.name for joint in members]
        for name in target:
            if name not in names:
                raise PlanningError(
                    "invalid_goal",
                    f"joint '{name}' is not in group '{group}'; {one_of(names, name)}",
                )
        wanted = self._robot.with_followers(target)
        return np.array(
            [
                _within(joint, wanted.get(joint.name, start[joint.name]), start[joint.name])
                for joint in members
            ]
        )

    def pose(
        self,
        group: str,
        pose: Pose,
        start: Mapping[str, float] | None = None,
        *,
        link: str | None = None,
        scaling: Scaling | None = None,
    ) -> JointTrajectory:
        """Return the move of `group` that brings `link` (its tip) to `pose`.

        Raises PlanningError("no_ik_solution") for a pose out of reach.
        """
        start = self._begin(start or {})
        target = self._kinematics.target(group, pose, link)
        goals = self.reach_each(group, [target], seed=start)
        return self.to_one_of(group, goals, start, scaling=scaling)

    def reach(
        self,
        group: str,
        pose: Pose,
        *,
        seed: Mapping[str, float],
        link: str | None = None,
    ) -> dict[str, float]:
        """Return joint positions that bring `link` (the tip) to `pose`, clear of everything.

        The search begins at `seed`, which also says where the other joints are.

        Raises PlanningError("no_ik_solution") for a pose out of reach, ("collision") for one that
        is reached in collision only.
        """
        target = self._kinematics.target(group, pose, link)
        return next(self.reach_each(group, [target], seed=seed))

    def reach_each(
        self,
        group: str,
        targets: Sequence[LinkTarget],
        *,
        seed: Mapping[str, float],
        breach: Callable[[Mapping[str, float]], str | None] = lambda positions: None,  # noqa: ARG005
        bounds: Mapping[str, Bounds] | None = None,
    ) -> Iterator[dict[str, float]]:
        """Yield joint positions that bring each link to its pose, clear of all, nearest first.

        `breach` says of joint positions why they are none, `bounds` within what joints must be.
        Raises PlanningError as `reach` does, where there are none.
        """
        tables = self._reached(group, targets, seed, breach, bounds)
        return _other_first(tables) if self.takes_other else tables

    def _reached(
        self,
        group: str,
        targets: Sequence[LinkTarget],
        seed: Mapping[str, float],
        breach: Callable[[Mapping[str, float]], str | None],
        bounds: Mapping[str, Bounds] | None,
    ) -> Iterator[dict[str, float]]:
        pair: tuple[str, str] | None = None
        broken: str | None = None
        count = 0
        for solution in self._kinematics.solutions(group, targets, seed=seed, bounds=bounds):
            there = {**seed, **solution}
            if reason := breach(there):
                broken = broken or f"the goal cannot be met as a whole: {reason}"
            elif reason := self._clearance.breach(there):
                broken = broken or (
                    f"the goal breaks the path constraints however it is reached: {reason}"
                )
            elif touching := self._clearance.collision(there):
                pair = pair or touching
            else:
                count += 1
                yield solution
        if count:
            return
        if pair is None:
            raise PlanningError("no_plan", broken or "")
        raise PlanningError(
            "collision",
            f"the goal is in collision however it is reached: '{pair[0]}' touches '{pair[1]}'",
        )

    def cartesian(
        self,
        group: str,
        waypoints: Sequence[Pose],
        start: Mapping[str, float] | None = None,
        *,
        link: str | None = None,
        eef_step: float = 0.01,
        avoid_collisions: bool = True,
        scaling: Scaling | None = None,
    ) -> tuple[JointTrajectory, float]:
        """Return the move of `link` in straight lines through `waypoints`, and how much of it.

        The path is followed in steps of `eef_step` [m] until a pose is out of reach, the joints
        would have to jump, the rule of `Clearance.keeping` is broken or, with
        `avoid_collisions`, something is touched; the fraction achieved is in [0, 1].
        """
        start = self._begin(start or {})
        if not math.isfinite(eef_step) or eef_step <= 0.0:
            raise PlanningError("bad_request", f"eef_step {eef_step} m; give a length above 0")
        members = self._members(group)
        names = tuple(joint.name for joint in members)
        tip = link or self._robot.group(group).tip_link
        if tip is None:
            raise PlanningError("bad_request", f"group '{group}' has no tip link; name one")
        here = self._kinematics.forward(start, tip)
        targets = straight_steps([here, *waypoints], eef_step)
        path = [np.array([start[name] for name in names])]
        for target in targets:

            def reach(guess: NDArray[np.float64], target: Pose = target) -> _Reached | None:
                seed = {**start, **dict(zip(names, guess.tolist(), strict=True))}
                return self._reach(group, target, tip, names, seed, path[-1])

            result = reach(_onward(path))
            if len(path) == 1 and (result is None or result[0] > _JUMP):
                # Stretched out or with wrist axes in line, a descent leads nowhere or far off.
                near = [result, *(reach(guess) for guess in _nudged(path[-1]))]
                result = min(
                    (item for item in near if item), key=lambda pair: pair[0], default=None
                )
            if result is None or result[0] > (_LEAVING if len(path) == 1 else _JUMP):
                break
            path.append(result[1])
        if avoid_collisions or self._clearance.has_rule:
            count = self._clearance.free_share(
                members, start, path, avoid_collisions=avoid_collisions
            )
            path = path[:count]
        fraction = (len(path) - 1) / len(targets) if targets else 1.0
        is_free = self._clearance.judge(members, start, avoid_collisions=avoid_collisions)
        timed = along_free_path(path, *self._limits(members, scaling), is_free)
        return JointTrajectory(names, *timed), fraction

    def _reach(
        self,
        group: str,
        target: Pose,
        tip: str,
        names: Sequence[str],
        seed: Mapping[str, float],
        here: NDArray[np.float64],
    ) -> _Reached | None:
        """Return how the joints come from `here` to a pose near by, None where they cannot."""
        try:
            near = LinkTarget(tip, target, 1e-6, 1e-5)
            values = self._kinematics.inverse_all(group, [near], seed=seed, restarts=0)
        except PlanningError as failure:
            if failure.failure != "no_ik_solution":
                raise
            return None
        reached = np.array([values[name] for name in names])
        return float(np.abs(reached - here).max()), reached

    def retime(
        self,
        trajectory: JointTrajectory,
        scaling: Scaling | None = None,
        *,
        path_tolerance: float = PATH_TOLERANCE,
        resample_s: float = RESAMPLE_S,
        min_angle_change: float = MIN_ANGLE_CHANGE,
    ) -> JointTrajectory:
        """Return the path through the same points, timed anew under the limits.

        `path_tolerance`, `resample_s` and `min_angle_change` are those of `timing.along_path`.
        Raises PlanningError("bad_request") for one of them that is not a number above 0.
        """
        for what, value in (
            ("path tolerance", path_tolerance),
            ("time between points", resample_s),
            ("least change of angle", min_angle_change),
        ):
            if not (math.isfinite(value) and value > 0.0):
                raise PlanningError("bad_request", f"{what} {value:g}; give a number above 0")
        members = [self._robot.joint(name) for name in trajectory.joints]
        first = dict(zip(trajectory.joints, trajectory.position[0].tolist(), strict=True))
        is_free = self._clearance.judge(members, self._begin(first))
        timed = along_free_path(
            trajectory.position,
            *self._limits(members, scaling),
            is_free,
            tolerance=path_tolerance,
            resample_s=resample_s,
            min_angle_change=min_angle_change,
        )
        return JointTrajectory(trajectory.joints, *timed)

    def _members(self, group: str) -> list[Joint]:
        return [self._robot.joint(name) for name in self._robot.group(group).joints]

    def _limits(
        self, joints: Sequence[Joint], scaling: Scaling | None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        scaling = scaling or self._robot.default_scaling
        v = _fraction("velocity", scaling.velocity)
        a = _fraction("acceleration", scaling.acceleration)
        return (
            np.array([joint.planned_velocity * v for joint in joints]),
            np.array([joint.planned_acceleration * a for joint in joints]),
        )


def _other_first(found: Iterator[dict[str, float]]) -> Iterator[dict[str, float]]:
    """Yield solutions with the first that is another posture than the nearest before all others."""
    nearest = next(found)
    passed = [nearest]
    for other in islice(found, _MOST_PASSED):
        off = max(abs(other[name] - value) for name, value in nearest.items())
        if _OTHER < off < (_FLIPPED if len(nearest) <= _SPARE else _ELBOW):
            yield other
            break
        passed.append(other)
    yield from passed
    yield from found


def _onward(path: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return where the joints come if they go on as in the last step: a start near the goal."""
    return 2 * path[-1] - path[-2] if len(path) > 1 else path[-1]


def _nudged(here: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Yield positions near by, one joint moved a little in either direction."""
    for offset in _NUDGES:
        for joint in range(len(here)):
            guess = here.copy()
            guess[joint] += offset
            yield guess


def _fraction(what: str, value: float) -> float:
    if not 0.0 < value <= 1.0:
        raise PlanningError(
            "bad_request", f"{what} scaling {value:g}; give a number above 0, at most 1"
        )
    return value


def _within(joint: Joint, value: float, near: float) -> float:
    if joint.type == "continuous" and math.isfinite(value):
        return turned_near(joint, float(value), near, (-math.inf, math.inf))
    if not joint.lower - _LIMIT_SLACK <= value <= joint.upper + _LIMIT_SLACK:
        raise PlanningError(
            "invalid_goal",
            f"{value:g} for joint '{joint.name}' is outside its limits "
            f"{shown_limits(joint, value)}",
        )
    return min(max(float(value), joint.lower), joint.upper)
