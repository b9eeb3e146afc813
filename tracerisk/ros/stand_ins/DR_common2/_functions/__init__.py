"""Doosan's functions, which DSR_ROBOT offers in ROS 1 and DSR_ROBOT2 in ROS 2.

Sources: doosan-robotics/doosan-robot common/imp/DSR_ROBOT.py and doosan-robotics/doosan-robot2
common2/imp/DSR_ROBOT2.py. Angles are in degrees, lengths in millimetres.
"""

# ruff: noqa: F401, F403 - as the libraries do
from __future__ import annotations

from DR_common2 import *
from DRFC import *

from tracerisk.ros.imports.exported import exported as _exported

from ._box import DR_BASE, DR_COND_NONE, DR_TC_USER_MAX, DR_TC_USER_MIN, DR_TOOL, DR_WORLD
from ._force import *
from ._motions import *
from ._states import *
from ._tools import *

DR_SOL_MIN, DR_SOL_MAX = 0, 7
DR_MV_RA_NONE = DR_MV_COMMAND_NORM = 0
DR_STATE_IDLE, DR_STATE_INIT, DR_STATE_BUSY, DR_STATE_BLEND = range(4)
DR_STATE_ACC, DR_STATE_CRZ, DR_STATE_DEC = 4, 5, 6
DR_AXIS_X, DR_AXIS_Y = 0, 1
DR_AXIS_A, DR_AXIS_B, DR_AXIS_C = 10, 11, 12
DR_OP_SPEED_MIN, DR_OP_SPEED_MAX = 1, 100
DR_QSTOP_STO, DR_QSTOP, DR_SSTOP, DR_HOLD = range(4)
DR_ANALOG_CURRENT, DR_ANALOG_VOLTAGE = 0, 1
DR_FIFO, DR_LIFO = 0, 1
DR_DPOS, DR_DVEL = 0, 1
DR_MV_ORI_TEACH, DR_MV_ORI_FIXED, DR_MV_ORI_RADIAL = range(3)
DR_MV_APP_NONE, DR_MV_APP_WELD = 0, 1

__all__ = _exported(globals())
