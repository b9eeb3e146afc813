"""Descend from a start to joint positions that bring links to targets, within joint limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics import builder  # noqa: F401 - says that no window is needed
from tracerisk.twin.physics.motion import LinkTarget, PlanningError, Pose

# After the builder, which says that no window is needed.
import daqp  # isort: skip
from tracerisk.twin.motion.mink_alone import mink  # isort: skip

_MAX_ITERATIONS = 40
TURN_COST = 0.3
"""Of a turn that is missed, beside a distance [m/rad]."""
_FREE_TURN_COST = 1e-3  # where any turn will do, and the nearest is wanted [m/rad]
_STALLED = 1e-8  # a step this small changes nothing more [rad]
_DAMPING = 1e-6  # of a step, beside the squares of what is missed
_UNBOUNDED = -1e30  # what DAQP takes for no lower bound
_EQUAL = 5  # what DAQP calls a constraint that holds with equality

Miss = tuple[float, float]
"""The distance [m] and the turn [rad] from a target."""


@dataclass(eq=False)
class Descent:
    """Gauss-Newton steps under joint limits (a quadratic program each) towards poses of links."""

    _configuration: Any
    """The robot's joint positions (`mink.Configuration`), changed by the descent."""
    _limits: list[Any]
    """The joint limits, as constraints of mink."""
    _frozen: list[Any] | None
    """The constraint that holds all other joints still; `None` where all may move."""
    _targets: Sequence[LinkTarget]
    """The poses to which links are brought."""

    def __post_init__(self) -> None:
        self._tasks = [
            mink.FrameTask(
                target.link, "body", position_cost=1.0, orientation_cost=_turn_cost(target)
            )
            for target in self._targets
        ]
        for task, target in zip(self._tasks, self._targets, strict=True):
            task.set_target(_target(target.pose))

    def descend(self, start: NDArray[np.float64]) -> tuple[NDArray[np.float64] | None, Miss]:
        """Return the configuration reached, `None` if short of a target, and the miss."""
        configuration = self._configuration
        configuration.update(start)
        miss = (math.inf, math.inf)
        for _ in range(_MAX_ITERATIONS):
            miss, is_there = self._miss()
            if is_there:
                return configuration.q.copy(), miss
            velocity = self._velocity()
            if velocity is None:
                return None, miss
            if float(np.abs(velocity).max()) < _STALLED:
                return None, miss
            configuration.integrate_inplace(velocity, 1.0)
        return None, miss

    def _velocity(self) -> NDArray[np.float64] | None:
        """Return the step that a quadratic program finds, (n_dofs,), `None` where it finds none."""
        residuals = [task.compute_qp_residual(self._configuration) for task in self._tasks]
        weighted = np.vstack([jacobian for jacobian, _, _ in residuals])
        cost = weighted.T @ weighted
        cost.flat[:: len(cost) + 1] += _DAMPING
        gradient = -(np.concatenate([error for _, error, _ in residuals]) @ weighted)
        limits = [limit.compute_qp_inequalities(self._configuration, 1.0) for limit in self._limits]
        bounded = [limit for limit in limits if not limit.inactive]
        still = [
            (task.compute_jacobian(self._configuration), task.compute_error(self._configuration))
            for task in self._frozen or ()
        ]
        none = np.zeros((0, len(cost)))
        rows = [none, *(limit.G for limit in bounded), *(jacobian for jacobian, _ in still)]
        bounds = [none[:, 0], *(limit.h for limit in bounded), *(-error for _, error in still)]
        upper = np.concatenate(bounds)
        sense = np.zeros(len(upper), dtype=np.intc)
        sense[len(upper) - sum(len(error) for _, error in still) :] = _EQUAL
        velocity: NDArray[np.float64]
        velocity, _, exit_flag, _ = daqp.solve(
            cost, gradient, np.vstack(rows), upper, np.full(len(upper), _UNBOUNDED), sense
        )
        return velocity if exit_flag > 0 else None

    def _miss(self) -> tuple[Miss, bool]:
        """Return the furthest miss of a target, and whether all are reached."""
        misses, is_there = [], True
        for task, target in zip(self._tasks, self._targets, strict=True):
            error = task.compute_error(self._configuration)
            distance, turn = (float(np.linalg.norm(part)) for part in (error[:3], error[3:]))
            misses.append((distance, turn))
            is_near = distance <= target.position_tolerance
            is_there = is_there and is_near and turn <= target.orientation_tolerance
        return max(misses, key=miss_cost, default=(0.0, 0.0)), is_there


def _turn_cost(target: LinkTarget) -> float:
    return TURN_COST if math.isfinite(target.orientation_tolerance) else _FREE_TURN_COST


def miss_cost(miss: Miss) -> float:
    """Return the cost of a miss, as a distance [m]."""
    return miss[0] + TURN_COST * miss[1]


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
