"""Stand-in for pymoveit2: MoveIt 2 over its actions and services, which the twin serves."""

from . import robots
from .gripper_command import GripperCommand
from .gripper_interface import GripperInterface
from .moveit2 import MoveIt2, MoveIt2State
from .moveit2_gripper import MoveIt2Gripper

__all__ = [
    "GripperCommand",
    "GripperInterface",
    "MoveIt2",
    "MoveIt2Gripper",
    "MoveIt2State",
    "robots",
]
