"""Stand-in for moveit_python: MoveIt by its actions and services (ROS 1)."""

from .move_group_interface import MoveGroupInterface
from .pick_place_interface import PickPlaceInterface
from .planning_scene_interface import PlanningSceneInterface

__all__ = ["MoveGroupInterface", "PickPlaceInterface", "PlanningSceneInterface"]
