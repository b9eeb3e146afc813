"""The answer of the planner."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from .._library import HandedOut, new
from .robot_trajectory import RobotTrajectory

__all__ = ["MotionPlanResponse"]


class MotionPlanResponse(HandedOut):
    """A trajectory, or the code of the failure; true where there is a trajectory."""

    _trajectory: RobotTrajectory | None
    _code: int
    _start_state: Any
    _planner_id: str

    def __bool__(self) -> bool:
        return self._code == 1

    @property
    def trajectory(self) -> RobotTrajectory | None:
        """The planned trajectory, None where planning failed."""
        return self._trajectory

    @property
    def planning_time(self) -> float:
        """The time that planning took [s]: none, for the clock stands still meanwhile."""
        return 0.0

    @property
    def error_code(self) -> Any:
        """How planning went, as MoveItErrorCodes."""
        message = new("moveit_msgs/MoveItErrorCodes")
        message.val = self._code
        return message

    @property
    def start_state(self) -> Any:
        """Where the plan begins, as a RobotState message."""
        return self._start_state

    planner_id = property(attrgetter("_planner_id"), doc="The planner that was asked for.")
