"""Descend from a start to joint positions that bring links to targets, within joint limits."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.twin.physics import builder  # noqa: F401 - says that no window is needed
from tracerisk.twin.physics.motion import LinkTarget, PlanningError, Pose

# After the builder, which says that no window is needed.
import daqp  # noqa: F401  # isort: skip - mink looks for it only when it solves

# scipy, below mink, takes over every name of numpy, and would import f2py for it: a front end of
# compilers that no run calls, and a fortieth of the processor time of one.
with ExitStack() as _without_f2py:
    if "numpy.f2py" not in sys.modules:
        np.f2py = ModuleType("numpy.f2py")
        _without_f2py.callback(delattr, np, "f2py")
    import mink

_MAX_ITERATIONS = 40
TURN_COST = 0.3
"""Of a turn that is missed, beside a distance [m/rad]."""
_FREE_TURN_COST = 1e-3  # where any turn will do, and the nearest is wanted [m/rad]
_STALLED = 1e-8  # a step this small changes nothing more [rad]

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
