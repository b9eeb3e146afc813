# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for actionlib, the actions of ROS 1."""

import threading

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray

from tracerisk.ros.imports.exported import exported as _exported

from .action_client import (
    ActionClient,
    ClientGoalHandle,
    CommState,
    CommStateMachine,
    TerminalState,
    get_name_of_constant,
)
from .action_server import ActionServer, nop_cb
from .exceptions import ActionException
from .goal_id_generator import GoalIDGenerator
from .server_goal_handle import ServerGoalHandle
from .simple_action_client import SimpleActionClient, SimpleGoalState
from .simple_action_server import SimpleActionServer

__all__ = _exported(globals(), "rospy", "threading")
