"""The parameters of a controller of joint trajectories, as files of the workspace give them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

_MOVES_BY_POSITION = ("position",)


@dataclass(frozen=True, slots=True)
class TrajectorySettings:
    """What a controller does with trajectories; where nothing is said, as its source has it.

    Parameters: ros-controls/ros2_controllers
    joint_trajectory_controller/src/joint_trajectory_controller_parameters.yaml, and
    ros-controls/ros_controllers joint_trajectory_controller/include/joint_trajectory_controller.
    """

    joints: tuple[str, ...] = ()
    """Its joints, in its own order; empty where nothing says which they are."""
    is_declared: bool = False
    """Whether a file gives its parameters: what it leaves out then has its default."""
    takes_part_of_joints: bool = False
    """`allow_partial_joints_goal`."""
    integrates: bool = False
    """`allow_integration_in_goal_trajectories`: points may lack positions."""
    ends_moving: bool | None = None
    """`allow_nonzero_velocity_at_trajectory_end`; `None` is what the distribution has."""
    interpolates: bool = True
    """`interpolation_method`: false where it is `none`."""
    takes_effort: bool = False
    """Whether its `command_interfaces` have effort."""
    knows_velocity: bool = False
    """Whether it looks at errors of velocity: its `command_interfaces` have more than position."""
    goal_time_s: float = 0.0
    """`constraints.goal_time` [s]."""
    stopped_velocity: float = 0.01
    """`constraints.stopped_velocity_tolerance` [rad/s or m/s]."""
    path: Mapping[str, float] = field(default_factory=dict)
    """`constraints.<joint>.trajectory` of joints that have one [rad or m]."""
    goal: Mapping[str, float] = field(default_factory=dict)
    """`constraints.<joint>.goal` of joints that have one [rad or m]."""
    wraps: frozenset[str] = frozenset()
    """Joints with `gains.<joint>.angle_wraparound`."""

    @classmethod
    def of(cls, joints: Iterable[str], values: Mapping[str, Any]) -> TrajectorySettings:
        """Return what the dotted names below a controller say; without any, nothing is declared."""
        names = tuple(joints)
        interfaces = values.get("command_interfaces") or _MOVES_BY_POSITION
        constraints = {
            which: {
                name: limit
                for name in names
                if (limit := _number(values, f"constraints.{name}.{which}", 0.0)) > 0.0
            }
            for which in ("trajectory", "goal")
        }
        ends = values.get("allow_nonzero_velocity_at_trajectory_end")
        return cls(
            names,
            is_declared=bool(values),
            takes_part_of_joints=values.get("allow_partial_joints_goal") is True,
            integrates=values.get("allow_integration_in_goal_trajectories") is True,
            ends_moving=ends if isinstance(ends, bool) else None,
            interpolates=values.get("interpolation_method") != "none",
            takes_effort="effort" in interfaces,
            knows_velocity="velocity" in interfaces or "effort" in interfaces,
            goal_time_s=_number(values, "constraints.goal_time", 0.0),
            stopped_velocity=_number(values, "constraints.stopped_velocity_tolerance", 0.01),
            path=constraints["trajectory"],
            goal=constraints["goal"],
            wraps=frozenset(
                name for name in names if values.get(f"gains.{name}.angle_wraparound") is True
            ),
        )


def _number(values: Mapping[str, Any], name: str, default: float) -> float:
    value = values.get(name)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if is_number and value is not None else default
