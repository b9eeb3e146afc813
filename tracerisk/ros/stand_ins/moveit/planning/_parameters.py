"""How to plan: which planner, how long, how fast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.ros.moveit.plan_records import valid_fraction
from tracerisk.twin.robots.robot_parts import Scaling

if TYPE_CHECKING:
    from ._moveit_py import MoveItPy

_DEFAULTS: dict[str, Any] = {
    "planner_id": "",
    "planning_pipeline": "",
    "planning_time": 1.0,
    "planning_attempts": 5,
    "max_velocity_scaling_factor": 1.0,
    "max_acceleration_scaling_factor": 1.0,
}


class PlanRequestParameters:
    """The parameters of one plan: those of the node below `<ns>.plan_request_params`.

    What the node has not is as in the real library: rated speeds, 1 s, five attempts. The twin
    has one planner, whatever its name, but LIN of pilz_industrial_motion_planner, which goes in
    a straight line.
    """

    planner_id: str
    planning_pipeline: str
    planning_time: float
    planning_attempts: int
    max_velocity_scaling_factor: float
    max_acceleration_scaling_factor: float

    def __init__(self, moveit_cpp: MoveItPy, ns: str = "") -> None:
        prefix = f"{ns}.plan_request_params." if ns else "plan_request_params."
        for name, default in _DEFAULTS.items():
            parameter = moveit_cpp._parameter(prefix + name, default)
            setattr(self, name, type(default)(parameter))

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _DEFAULTS:
            raise AttributeError(
                f"'PlanRequestParameters' object has no attribute '{name}'; "
                f"it has: {', '.join(sorted(_DEFAULTS))}"
            )
        wanted = type(_DEFAULTS[name])
        if not isinstance(value, (int, float) if wanted is float else wanted):
            raise TypeError(f"{name} is of type {wanted.__name__}, not {type(value).__name__}")
        object.__setattr__(self, name, wanted(value))

    def _scaling(self) -> Scaling:
        return Scaling(
            valid_fraction(self.max_velocity_scaling_factor),
            valid_fraction(self.max_acceleration_scaling_factor),
        )

    def _key(self) -> tuple[Any, ...]:
        return tuple(getattr(self, name) for name in _DEFAULTS)


class MultiPipelinePlanRequestParameters:
    """The parameters of several plans, one for each pipeline named."""

    def __init__(self, moveit_cpp: MoveItPy, planning_pipeline_names: Sequence[str]) -> None:
        self._all = [PlanRequestParameters(moveit_cpp, name) for name in planning_pipeline_names]

    @property
    def multi_plan_request_parameters(self) -> list[PlanRequestParameters]:
        """The parameters of each plan."""
        return list(self._all)
