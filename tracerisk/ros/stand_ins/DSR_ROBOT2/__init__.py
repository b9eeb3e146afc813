"""Stand-in for DSR_ROBOT2 of Doosan: functions that call the services of the arm's controller.

A program first sets the node in DR_init. Angles are in degrees, lengths in millimetres.
Source: doosan-robotics/doosan-robot2 common2/imp/DSR_ROBOT2.py.
"""

# ruff: noqa: F401, F403 - as the library does
from __future__ import annotations

from DR_common2._functions import *
from DR_common2._functions._calls import g_node
from dsr_msgs2.msg import *
from dsr_msgs2.srv import *

from tracerisk.ros.imports.exported import exported as _exported

__all__ = _exported(globals())
