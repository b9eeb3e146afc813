"""Forward and inverse kinematics of the robot alone, apart from the running simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.motion.plausible_units import length_guess
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import LinkTarget, PlanningError, Pose
from tracerisk.twin.robots.robot import Joint, Robot

# After the builder, which says that no window is needed.
import daqp  # noqa: F401  # isort: skip - mink looks for it only when it solves
import mink  # isort: skip
import mujoco  # isort: skip

_TURN = 2 * math.pi

_MAX_ITERATIONS = 40
_RESTARTS = 24  # an arm without a common point of its wrist axes needs as many
_TURN_COST = 0.3  # of a turn that is missed, beside a distance [m/rad]
_FREE_TURN_COST = 1e-3  # where any turn will do, and the nearest is wanted [m/rad]
_MOST_KEPT = 10_000  # poses out of reach that are remembered
_STALLED = 1e-8  # a step this small changes nothing more [rad]

Bounds = tuple[float, float]
"""The least and the greatest position of a joint [rad or m]."""
_Miss = tuple[float, float]  # the distance [m] and the turn [rad] from a target


class Kinematics:
    """The robot's kinematics; each call gives the same answer for the same arguments.

    Poses are in the frame of the robot's base link.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._model = compile_model(robot)
        self._data = mujoco.MjData(self._model)
        joints = {joint.name: self._model.joint(joint.name) for joint in robot.joints}
        self._address = {name: int(each.qposadr[0]) for name, each in joints.items()}
        self._dof = {name: int(each.dofadr[0]) for name, each in joints.items()}
        self._configuration = mink.Configuration(self._model)
        self._limits = [mink.ConfigurationLimit(self._model, gain=1.0)]
        self._unreached: dict[Hashable, _Miss] = {}
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
        found = np.zeros((2, 3, self._model.nv))
        mujoco.mj_jac(self._model, self._data, *found, self._data.xpos[body], body)
        return found.reshape(6, -1)[:, [self._dof[name] for name in joints]]

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

        The search starts at `seed`, then at the group's named states, then at positions drawn
        from a generator that begins anew with each call; what `accept` refuses is passed over.

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

        The search is that of `inverse`, and so are the errors. It keeps the joints in `bounds`
        within these, too.
        """
        members = self._robot.group(group)
        for target in targets:
            self._link(target.link)
        if members.turns_freely:
            targets = [replace(target, orientation_tolerance=math.inf) for target in targets]
        # What no start reaches is out of reach for the next who asks, too.
        near = tuple((name, round(value, 3)) for name, value in sorted((seed or {}).items()))
        ranges = {joint.name: _range(joint, bounds or {}) for joint in self._robot.joints}
        asked = (group, tuple(targets), near, restarts, tuple((bounds or {}).items()))
        if asked in self._unreached:
            raise self._out_of_reach(group, targets, seed or {}, self._unreached[asked])
        limits = self._limits if not bounds else [self._limit(ranges)]
        search = _Search(self._configuration, limits, self._frozen(members.joints), targets)
        best = (math.inf, math.inf)
        is_reached = False
        for start in self._starts(group, seed or {}, restarts, ranges):
            found, error = search.descend(start)
            if found is not None:
                is_reached = True
                reached = self._within_limits(members.joints, found, ranges)
                if accept is None or accept(reached):
                    return reached
            best = min(best, error, key=_cost)
        if not is_reached and len(self._unreached) < _MOST_KEPT:
            self._unreached[asked] = best
        raise self._out_of_reach(group, targets, seed or {}, best)

    def _out_of_reach(
        self, group: str, targets: Sequence[LinkTarget], seed: Mapping[str, float], best: _Miss
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

    def _starts(
        self,
        group: str,
        seed: Mapping[str, float],
        restarts: int,
        ranges: Mapping[str, Bounds],
    ) -> Iterator[NDArray[np.float64]]:
        at_seed = self._clipped(self.positions(seed), ranges)
        yield at_seed
        if restarts == 0:
            return
        for state in self._robot.named_states.get(group, {}).values():
            yield self._clipped(self.positions({**seed, **state}), ranges)
        generator = np.random.default_rng(0)
        for _ in range(restarts):
            start = at_seed.copy()
            for name in self._robot.group(group).joints:
                start[self._address[name]] = generator.uniform(*ranges[name])
            yield start

    def _clipped(
        self, qpos: NDArray[np.float64], ranges: Mapping[str, Bounds]
    ) -> NDArray[np.float64]:
        for joint in self._robot.joints:
            at = self._address[joint.name]
            qpos[at] = _inside(joint, float(qpos[at]), ranges[joint.name])
        return qpos

    def _within_limits(
        self, names: tuple[str, ...], qpos: NDArray[np.float64], ranges: Mapping[str, Bounds]
    ) -> dict[str, float]:
        values = {}
        for name in names:
            value = float(qpos[self._address[name]])
            values[name] = _inside(self._robot.joint(name), value, ranges[name])
        return values

    def _limit(self, ranges: Mapping[str, Bounds]) -> mink.ConfigurationLimit:
        """Return the limits of the search, narrowed to `ranges`."""
        limit = mink.ConfigurationLimit(self._model, gain=1.0)
        for name, (lower, upper) in ranges.items():
            if limit.lower[self._address[name]] > -mujoco.mjMAXVAL:
                limit.lower[self._address[name]] = lower
                limit.upper[self._address[name]] = upper
        return limit

    def _frozen(self, members: tuple[str, ...]) -> list[Any] | None:
        others = sorted(set(self._dof.values()) - {self._dof[name] for name in members})
        return [mink.DofFreezingTask(self._model, others)] if others else None

    def _link(self, name: str) -> int:
        if name not in self._body:
            raise RobotError(
                f"robot '{self._robot.name}' has no link '{name}'; {one_of(self._body, name)}"
            )
        return self._body[name]


@dataclass(eq=False)
class _Search:
    """Gauss-Newton steps under joint limits (a quadratic program each) towards poses of links."""

    _configuration: Any
    _limits: list[Any]
    _frozen: list[Any] | None
    _targets: Sequence[LinkTarget]

    def __post_init__(self) -> None:
        self._tasks = [
            mink.FrameTask(
                target.link, "body", position_cost=1.0, orientation_cost=_turn_cost(target)
            )
            for target in self._targets
        ]
        for task, target in zip(self._tasks, self._targets, strict=True):
            task.set_target(_target(target.pose))

    def descend(self, start: NDArray[np.float64]) -> tuple[NDArray[np.float64] | None, _Miss]:
        """Return the configuration reached, `None` if short of a target, and the miss."""
        configuration = self._configuration
        configuration.update(start)
        miss = (math.inf, math.inf)
        for _ in range(_MAX_ITERATIONS):
            miss, is_there = self._miss()
            if is_there:
                return configuration.q.copy(), miss
            try:
                velocity = mink.solve_ik(
                    configuration,
                    self._tasks,
                    1.0,
                    solver="daqp",
                    damping=1e-6,
                    limits=self._limits,
                    constraints=self._frozen,
                )
            except mink.NoSolutionFound:
                return None, miss
            if float(np.abs(velocity).max()) < _STALLED:
                return None, miss
            configuration.integrate_inplace(velocity, 1.0)
        return None, miss

    def _miss(self) -> tuple[_Miss, bool]:
        """Return the furthest miss of a target, and whether all are reached."""
        misses, is_there = [], True
        for task, target in zip(self._tasks, self._targets, strict=True):
            error = task.compute_error(self._configuration)
            distance, turn = (float(np.linalg.norm(part)) for part in (error[:3], error[3:]))
            misses.append((distance, turn))
            is_near = distance <= target.position_tolerance
            is_there = is_there and is_near and turn <= target.orientation_tolerance
        return max(misses, key=_cost, default=(0.0, 0.0)), is_there


def _turn_cost(target: LinkTarget) -> float:
    return _TURN_COST if math.isfinite(target.orientation_tolerance) else _FREE_TURN_COST


def _cost(miss: _Miss) -> float:
    return miss[0] + _TURN_COST * miss[1]


def _range(joint: Joint, bounds: Mapping[str, Bounds]) -> Bounds:
    """Return within which positions a joint may be: its limits, and its bounds if it has any."""
    lower, upper = bounds.get(joint.name, (joint.lower, joint.upper))
    return max(lower, joint.lower), min(upper, joint.upper)


def _inside(joint: Joint, value: float, within: Bounds) -> float:
    """Return a position within bounds: whole turns less or more, else at the limit."""
    lower, upper = within
    if joint.type == "continuous":
        # Whole turns lead to the same pose; a limit of the range would not.
        value -= _TURN * math.ceil(max(0.0, value - upper) / _TURN)
        value += _TURN * math.ceil(max(0.0, lower - value) / _TURN)
    return min(max(value, lower), upper)


def _shown(pose: Pose) -> str:
    x, y, z = pose.position
    return f"({x:.3f}, {y:.3f}, {z:.3f})"


def _target(pose: Pose) -> Any:
    x, y, z, w = pose.orientation
    quaternion = np.array([w, x, y, z], dtype=np.float64)
    norm = float(np.linalg.norm(quaternion))
    if not np.isfinite([*pose.position, norm]).all() or norm < 1e-6:
        raise PlanningError(
            "bad_request",
            f"position {pose.position}, orientation {pose.orientation} is not a pose; "
            "give finite numbers and a quaternion (x, y, z, w) that is not zero",
        )
    return mink.SE3.from_rotation_and_translation(
        mink.SO3(wxyz=quaternion / norm), np.asarray(pose.position, dtype=np.float64)
    )
