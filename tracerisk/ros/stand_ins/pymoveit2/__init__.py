# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for pymoveit2: MoveIt 2 over its actions and services, which the twin serves."""

from tracerisk.ros.imports.exported import exported as _exported

from . import robots
from .gripper_command import GripperCommand
from .gripper_interface import GripperInterface
from .moveit2 import MoveIt2, MoveIt2State
from .moveit2_gripper import MoveIt2Gripper

__all__ = _exported(globals(), "robots")
