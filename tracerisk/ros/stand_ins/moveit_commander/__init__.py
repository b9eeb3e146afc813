# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for moveit_commander: MoveIt's Python interface, on the twin."""

import os  # programs end with `moveit_commander.os._exit(0)`

from tracerisk.ros.imports.exported import exported as _exported

from .exception import MoveItCommanderException
from .move_group import MoveGroupCommander
from .planning_scene_interface import PlanningSceneInterface
from .robot import RobotCommander
from .roscpp_initializer import roscpp_initialize, roscpp_shutdown

__all__ = _exported(globals(), "os")
