"""Stand-in for DSR_ROBOT of Doosan: functions that call the services of the arm's controller.

A program first sets the robot's name and model in DR_init, below which the services are.
Source: doosan-robotics/doosan-robot common/imp/DSR_ROBOT.py, which also gives what it imports.
"""

# ruff: noqa: F401, F403 - as the library does
from __future__ import annotations

import os
import sys
import threading
import time
from math import *

import DR_init
import rospy
from DR_common2._functions import *
from DR_common2._functions._motions import stop as _stop
from dsr_msgs.msg import *
from dsr_msgs.srv import *
from std_msgs.msg import (
    Float32,
    Float32MultiArray,
    Float64,
    Float64MultiArray,
    Int32,
    Int32MultiArray,
    MultiArrayDimension,
    MultiArrayLayout,
    String,
)

from tracerisk.ros.imports.exported import exported as _exported


def move_stop(stop_mode: int = 0) -> int:
    """Stop the motion."""
    code: int = _stop(stop_mode)
    return code


__all__ = _exported(globals(), "DR_init", "os", "rospy", "sys", "threading", "time")
