# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for moveit_commander: MoveIt's Python interface, on the twin.

It also gives the messages that its modules import, for it imports all of their names.
Source: moveit/moveit moveit_commander/src/moveit_commander/__init__.py and move_group.py.
"""

import os  # programs end with `moveit_commander.os._exit(0)`

from geometry_msgs.msg import Point, Pose, PoseStamped
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    Constraints,
    Grasp,
    MotionPlanRequest,
    MoveItErrorCodes,
    PlaceLocation,
    PlannerInterfaceDescription,
    PlanningScene,
    RobotState,
    RobotTrajectory,
    TrajectoryConstraints,
)
from sensor_msgs.msg import JointState

from tracerisk.ros.imports.exported import exported as _exported

from .exception import MoveItCommanderException
from .move_group import MoveGroupCommander
from .planning_scene_interface import PlanningSceneInterface
from .robot import RobotCommander
from .roscpp_initializer import roscpp_initialize, roscpp_shutdown

__all__ = _exported(globals(), "os")
