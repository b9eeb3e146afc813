"""Forward and inverse kinematics of the robot alone, apart from the running simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.motion.branches import branches
from tracerisk.twin.motion.descent import Descent, Miss, miss_cost
from tracerisk.twin.motion.mink_alone import mink
from tracerisk.twin.motion.plausible_units import length_guess
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import LinkTarget, PlanningError, Pose
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Joint

# After the builder, which says that no window is needed.
import mujoco  # isort: skip

_TURN = 2 * math.pi

_RESTARTS = 24  # where no branch is found
_NEARBY = 1.0  # no other branch is nearer than a solution within this distance [rad or m]
_MOST_KEPT = 10_000  # poses out of reach that are remembered
_SAME = 1e-2  # two solutions that are nearer are one [rad or m]
_TURN_SLACK = 1e-6  # beyond a limit: an error of rounding [rad]

Bounds = tuple[float, float]
"""The least and the greatest position of a joint [rad or m]."""


class Kinematics:
    """The robot's kinematics; each call gives the same answer for the same arguments.

    Poses are in the frame of the robot's base link.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._model = compile_model(robot)
        self._data = mujoco.MjData(self._model)
        joints = {joint.name: self._model.joint(joint.name) for joint in robot.joints}
        self._address = {name: int(item.qposadr[0]) for name, item in joints.items()}
        self._dof = {name: int(item.dofadr[0]) for name, item in joints.items()}
        self._configuration = mink.Configuration(self._model)
        self._limits = [mink.ConfigurationLimit(self._model, gain=1.0)]
        # A straight line asks at each of its points.
        self._ranges = {joint.name: _range(joint, {}) for joint in robot.joints}
        self._turning = {joint.name for joint in robot.joints if _turns_further(joint)}
        self._frozen = cache(self._freezing)
        self._unreached: dict[Hashable, Miss] = {}
        self._body = {name: int(self._model.body(name).id) for name in robot.link_names}

    def positions(self, given: Mapping[str, float]) -> NDArray[np.float64]:
        """Return the model's configuration for joint positions; joints left out are at rest.

        Raises RobotError for a joint that the robot does not have.
        """
        qpos = np.zeros(self._model.nq)
        for name, value in {**self._robot.initial_state, **given}.items():
            if name not in self._address:
                raise RobotError(
                    f"robot '{self._robot.name}' has no joint '{name}'; "
                    f"{one_of(self._address, name)}"
                )
            qpos[self._address[name]] = value
        return qpos

    def forward(self, positions: Mapping[str, float], link: str) -> Pose:
        """Return the pose of `link` at the joint positions; raise RobotError for unknown names."""
        body = self._link(link)
        self._data.qpos[:] = self.positions(positions)
        mujoco.mj_kinematics(self._model, self._data)
        return Pose.of(self._data.xpos[body], self._data.xquat[body])

    def forward_all(self, positions: Mapping[str, float]) -> dict[str, Pose]:
        """Return the pose of every link at the joint positions; raise RobotError as `forward`."""
        self._data.qpos[:] = self.positions(positions)
        mujoco.mj_kinematics(self._model, self._data)
        xpos, xquat = self._data.xpos, self._data.xquat
        return {name: Pose.of(xpos[body], xquat[body]) for name, body in self._body.items()}

    def jacobian(
        self, positions: Mapping[str, float], link: str, joints: Sequence[str]
    ) -> NDArray[np.float64]:
        """Return how `link` moves with each of `joints`, (6, n): linear, then angular velocity.

        It is in the axes of the base link [m/s, rad/s for 1 rad/s or 1 m/s of the joint].
        Raises RobotError as `forward`.
        """
        body = self._link(link)
        self._data.qpos[:] = self.positions(positions)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        zeros = np.zeros((2, 3, self._model.nv))
        mujoco.mj_jac(self._model, self._data, *zeros, self._data.xpos[body], body)
        return zeros.reshape(6, -1)[:, [self._dof[name] for name in joints]]

    def inverse(
        self,
        group: str,
        pose: Pose,
        *,
        link: str | None = None,
        seed: Mapping[str, float] | None = None,
        restarts: int = _RESTARTS,
        accept: Callable[[Mapping[str, float]], bool] | None = None,
    ) -> dict[str, float]:
        """Return joint positions of `group` within limits that bring `link` to `pose`.

        They are the first of `solutions` that `accept` does not refuse.

        Raises PlanningError("no_ik_solution") when no start leads there, and
        PlanningError("bad_request") when the group has no tip link or the pose is not a pose.
        """
        target = self.target(group, pose, link)
        return self.inverse_all(group, [target], seed=seed, restarts=restarts, accept=accept)

    def target(self, group: str, pose: Pose, link: str | None = None) -> LinkTarget:
        """Return what brings `link`, the group's tip by default, to `pose`; raise as `inverse`."""
        tip = link or self._robot.group(group).tip_link
        if tip is None:
            raise PlanningError(
                "bad_request", f"group '{group}' has no tip link; name the link the pose is for"
            )
        return LinkTarget(tip, pose)

    def inverse_all(
        self,
        group: str,
        targets: Sequence[LinkTarget],
        *,
        seed: Mapping[str, float] | None = None,
        restarts: int = _RESTARTS,
        accept: Callable[[Mapping[str, float]], bool] | None = None,
        bounds: Mapping[str, Bounds] | None = None,
    ) -> dict[str, float]:
        """Return joint positions of `group` that bring each link to its pose, as with two arms.

        The search is that of `solutions`, and so are the errors.
        """
        solutions = self.solutions(group, targets, seed=seed, restarts=restarts, bounds=bounds)
        for solution in solutions:
            if accept is None or accept(solution):
                return solution
        raise PlanningError("no_ik_solution", f"no position of group '{group}' is accepted")

    def solutions(
        self,
        group: str,
        targets: Sequence[LinkTarget],
        *,
        seed: Mapping[str, float] | None = None,
        restarts: int = _RESTARTS,
        bounds: Mapping[str, Bounds] | None = None,
    ) -> Iterator[dict[str, float]]:
        """Yield the joint positions of `group` that bring each link to its pose, nearest first.

        Nearest to `seed` are those with the least sum of squared moves of the joints, each of which
        comes to the nearest turn within its limits. They are those of a descent from `seed` and of
        the `branches`. Where no joint turns further than once, those that descents from `seed` and
        from the group's named states reach come first, in this order. If nothing is found there are
        descents from `restarts` positions, drawn from a generator that begins anew with each call;
        with no restarts there is the first descent alone. All keep the joints in `bounds`.

        Raises PlanningError as `inverse` does, where there is none.
        """
        members = self._robot.group(group)
        for target in targets:
            self._link(target.link)
        if members.turns_freely:
            targets = [replace(target, orientation_tolerance=math.inf) for target in targets]
        seed = seed or {}
        # What no start reaches is out of reach for the next who asks, too.
        near = tuple((name, round(value, 3)) for name, value in sorted(seed.items()))
        ranges: Mapping[str, Bounds] = self._ranges
        if bounds:
            ranges = {joint.name: _range(joint, bounds) for joint in self._robot.joints}
        asked = (group, tuple(targets), near, restarts, tuple((bounds or {}).items()))
        if asked in self._unreached:
            raise self._out_of_reach(group, targets, seed, self._unreached[asked])
        limits = self._limits if not bounds else [self._limit(ranges)]
        search = Descent(self._configuration, limits, self._frozen(members.joints), targets)
        at_seed = self.positions(seed)
        best = (math.inf, math.inf)
        given: list[NDArray[np.float64]] = []

        def reached(start: NDArray[np.float64]) -> NDArray[np.float64] | None:
            nonlocal best
            found, miss = search.descend(self._clipped(start, ranges))
            best = min(best, miss, key=miss_cost)
            return None if found is None else self._turned(found, members.joints, at_seed, ranges)

        def is_new(found: NDArray[np.float64] | None) -> TypeGuard[NDArray[np.float64]]:
            return found is not None and all(_far(found, other) > _SAME for other in given)

        def handed(found: NDArray[np.float64]) -> dict[str, float]:
            given.append(found)
            return {name: float(found[self._address[name]]) for name in members.joints}

        turns = not self._turning.isdisjoint(members.joints)
        first = reached(at_seed.copy())
        if first is not None and (not turns or not restarts or _far(first, at_seed) <= _NEARBY):
            yield handed(first)
        if restarts and not turns:
            for start in self._named(group, at_seed):
                if is_new(found := reached(start)):
                    yield handed(found)
        if restarts:
            for start in self._branches(members.joints, targets, at_seed, ranges):
                if first is not None and not given and _far(first, at_seed) <= _far(start, at_seed):
                    yield handed(first)
                if is_new(found := reached(start)):
                    yield handed(found)
            if first is not None and not given:
                yield handed(first)
        if not given:
            for start in self._drawn(group, at_seed, restarts, ranges):
                if is_new(found := reached(start)):
                    yield handed(found)
        if not given:
            if len(self._unreached) < _MOST_KEPT:
                self._unreached[asked] = best
            raise self._out_of_reach(group, targets, seed, best)

    def _out_of_reach(
        self, group: str, targets: Sequence[LinkTarget], seed: Mapping[str, float], best: Miss
    ) -> PlanningError:
        asked, now = [], []
        for target in targets:
            here = self.forward(seed, target.link)
            guess = length_guess(target.pose.position, math.hypot(*here.position))
            asked.append(f"'{target.link}' to {_shown(target.pose)} m{guess}")
            now.append(_shown(here))
        return PlanningError(
            "no_ik_solution",
            f"no position of group '{group}' within its limits brings {' and '.join(asked)} with "
            f"the orientation asked for; the nearest found is {best[0] * 1000:.0f} mm and "
            f"{math.degrees(best[1]):.1f} degrees away, the link is now at {', '.join(now)} m; ask "
            "for a pose within reach",
        )

    def _branches(
        self,
        names: tuple[str, ...],
        targets: Sequence[LinkTarget],
        at_seed: NDArray[np.float64],
        ranges: Mapping[str, Bounds],
    ) -> list[NDArray[np.float64]]:
        """Return starts near the solutions of each branch, nearest first."""
        columns = [self._address[name] for name in names]
        limits = np.array([_search_range(self._robot.joint(name), ranges[name]) for name in names])
        self._data.qpos[:] = at_seed
        array = branches(self._model, self._data, targets, columns, *limits.T)
        starts = []
        for values in array:
            start = at_seed.copy()
            start[columns] = values
            starts.append(self._turned(start, names, at_seed, ranges))
        return sorted(starts, key=lambda start: (round(_far(start, at_seed), 4), *start))

    def _named(self, group: str, at_seed: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
        for state in self._robot.named_states.get(group, {}).values():
            start = at_seed.copy()
            for name, value in state.items():
                start[self._address[name]] = value
            yield start

    def _drawn(
        self, group: str, at_seed: NDArray[np.float64], count: int, ranges: Mapping[str, Bounds]
    ) -> Iterator[NDArray[np.float64]]:
        generator = np.random.default_rng(0)
        for _ in range(count):
            start = at_seed.copy()
            for name in self._robot.group(group).joints:
                joint, within = self._robot.joint(name), ranges[name]
                lower, upper = within if math.isfinite(sum(within)) else (joint.lower, joint.upper)
                start[self._address[name]] = generator.uniform(lower, upper)
            yield start

    def _clipped(
        self, qpos: NDArray[np.float64], ranges: Mapping[str, Bounds]
    ) -> NDArray[np.float64]:
        for joint in self._robot.joints:
            at = self._address[joint.name]
            qpos[at] = turned_near(joint, float(qpos[at]), float(qpos[at]), ranges[joint.name])
        return qpos

    def _turned(
        self,
        qpos: NDArray[np.float64],
        names: tuple[str, ...],
        at_seed: NDArray[np.float64],
        ranges: Mapping[str, Bounds],
    ) -> NDArray[np.float64]:
        """Return a configuration whose joints `names` come to the turns nearest to the seed."""
        turned: NDArray[np.float64] = qpos.copy()
        for name in names:
            at = self._address[name]
            near = float(at_seed[at])
            turned[at] = turned_near(self._robot.joint(name), float(qpos[at]), near, ranges[name])
        return turned

    def _limit(self, ranges: Mapping[str, Bounds]) -> mink.ConfigurationLimit:
        """Return the limits of the search, narrowed to `ranges`."""
        limit = mink.ConfigurationLimit(self._model, gain=1.0)
        for name, (lower, upper) in ranges.items():
            if limit.lower[self._address[name]] > -mujoco.mjMAXVAL:
                limit.lower[self._address[name]] = lower
                limit.upper[self._address[name]] = upper
        return limit

    def _freezing(self, members: tuple[str, ...]) -> list[Any] | None:
        others = sorted(set(self._dof.values()) - {self._dof[name] for name in members})
        return [mink.DofFreezingTask(self._model, others)] if others else None

    def _link(self, name: str) -> int:
        if name not in self._body:
            raise RobotError(
                f"robot '{self._robot.name}' has no link '{name}'; {one_of(self._body, name)}"
            )
        return self._body[name]


def _range(joint: Joint, bounds: Mapping[str, Bounds]) -> Bounds:
    """Return within which positions a joint may be: its limits, and its bounds if it has any."""
    endless = joint.type == "continuous"
    limits = (-math.inf, math.inf) if endless else (joint.lower, joint.upper)
    lower, upper = bounds.get(joint.name, limits)
    return max(lower, limits[0]), min(upper, limits[1])


def _is_whole(joint: Joint, within: Bounds) -> bool:
    """Return whether a joint comes to every direction within its range: a turn at the least."""
    return joint.type != "prismatic" and within[1] - within[0] >= _TURN - _TURN_SLACK


def _turns_further(joint: Joint) -> bool:
    """Return whether a joint may turn further than once: some poses are reached in two turns."""
    lower, upper = _range(joint, {})
    return joint.type != "prismatic" and upper - lower > _TURN + _TURN_SLACK


def _search_range(joint: Joint, within: Bounds) -> Bounds:
    return (-math.inf, math.inf) if _is_whole(joint, within) else within


def turned_near(joint: Joint, value: float, near: float, within: Bounds) -> float:
    """Return the position within bounds that is `value` but for whole turns, the nearest to `near`.

    Where no turn is within bounds, it is the bound nearest to `value`.
    """
    lower, upper = within
    # Whole turns lead to the same pose; a limit of the range would not.
    if _is_whole(joint, within):
        value += _TURN * round((near - value) / _TURN)
    if joint.type != "prismatic":
        turned = value - _TURN * _turns(value - upper)
        turned += _TURN * _turns(lower - turned)
        value = turned if turned <= upper + _TURN_SLACK else value
    return min(max(value, lower), upper)


def _turns(beyond: float) -> int:
    return math.ceil((beyond - _TURN_SLACK) / _TURN) if beyond > _TURN_SLACK else 0


def _far(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.square(one - other).sum()))


def _shown(pose: Pose) -> str:
    x, y, z = pose.position
    return f"({x:.3f}, {y:.3f}, {z:.3f})"
