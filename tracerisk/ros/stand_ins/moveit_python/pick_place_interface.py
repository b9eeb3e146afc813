"""Pick and place, carried out as `moveit_commander` does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
from moveit_commander import MoveGroupCommander
from moveit_msgs.msg import MoveItErrorCodes, PickupResult, PlaceResult

__all__ = ["PickPlaceInterface"]


class PickPlaceInterface:
    """Picks objects of the planning scene with a group, and places them."""

    def __init__(
        self,
        group: str = "arm",
        ee_group: str = "gripper",
        plan_only: bool = False,
        verbose: bool = False,
    ) -> None:
        self._group = group
        self.plan_only = plan_only
        self.planner_id: str | None = None
        self.allowed_planning_time = 30.0
        self._commander = MoveGroupCommander(group)

    def pickup(self, name: str, grasps: Any, wait: bool = True, **kwargs: Any) -> Any:
        """Pick an object by the first of the grasps that works; return the PickupResult.

        Raises:
            NotImplementedError: without waiting; the twin serves no action `pickup`.
        """
        plan_only = self._prepare("pickup", wait, kwargs)
        code = self._commander.pick(name, grasps, plan_only)
        return PickupResult(error_code=MoveItErrorCodes(val=int(code)))

    def place(self, name: str, locations: Any, wait: bool = True, **kwargs: Any) -> Any:
        """Place an object at the first of the locations that works; return the PlaceResult.

        Raises:
            NotImplementedError: without waiting; the twin serves no action `place`.
        """
        plan_only = self._prepare("place", wait, kwargs)
        is_placed = self._commander.place(name, locations, plan_only)
        code = MoveItErrorCodes.SUCCESS if is_placed else MoveItErrorCodes.PLANNING_FAILED
        return PlaceResult(error_code=MoveItErrorCodes(val=code))

    def _prepare(self, name: str, wait: bool, given: dict[str, Any]) -> Any:
        """Set what a call gives, and return whether it is only to be planned."""
        if not wait:
            raise NotImplementedError(
                f"PickPlaceInterface.{name} with wait=False: the twin serves no action '{name}'"
            )
        planner = given.get("planner_id", self.planner_id)
        if planner:
            self._commander.set_planner_id(planner)
        self._commander.set_planning_time(given.get("planning_time", self.allowed_planning_time))
        if "support_name" in given:
            self._commander.set_support_surface_name(given["support_name"])
        return given.get("plan_only", self.plan_only)

    def pick_with_retry(
        self, name: str, grasps: Any, retries: int = 5, scene: Any = None, **kwargs: Any
    ) -> list[Any]:
        """Pick, again where that failed; return whether it succeeded, and the last result."""
        return _retried("Pick", lambda: self.pickup(name, grasps, **kwargs), retries)

    def place_with_retry(
        self, name: str, locations: Any, retries: int = 5, scene: Any = None, **kwargs: Any
    ) -> list[Any]:
        """Place, again where that failed; return whether it succeeded, and the last result."""
        return _retried("Place", lambda: self.place(name, locations, **kwargs), retries)

    def setPlannerId(self, planner_id: str) -> None:
        """Set the planner of later requests."""
        self.planner_id = str(planner_id)

    def setPlanningTime(self, time: float) -> None:
        """Set the planning time of later requests [s]."""
        self.allowed_planning_time = time


def _retried(what: str, act: Callable[[], Any], retries: int) -> list[Any]:
    result = None
    for _ in range(retries):
        result = act()
        if result.error_code.val == MoveItErrorCodes.SUCCESS:
            rospy.loginfo(f"{what} succeeded")
            return [True, result]
        rospy.logerr(f"{what} failed with error code: {result.error_code.val}. Will retry...")
        rospy.sleep(0.5)
    rospy.logerr(f"{what} failed, and all retries are used")
    return [False, result]
