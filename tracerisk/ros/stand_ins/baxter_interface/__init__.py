# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for baxter_interface: Baxter's limbs, grippers, head, inputs, outputs and state, over
the graph."""

from tracerisk.ros.imports.exported import exported as _exported

from . import settings
from .analog_io import AnalogIO
from .digital_io import DigitalIO
from .gripper import Gripper
from .head import Head
from .limb import Limb
from .navigator import Navigator
from .robot_enable import RobotEnable
from .settings import (
    CHECK_VERSION,
    HEAD_PAN_ANGLE_TOLERANCE,
    JOINT_ANGLE_TOLERANCE,
    SDK_VERSION,
    VERSIONS_SDK2GRIPPER,
    VERSIONS_SDK2ROBOT,
)

__all__ = _exported(globals(), "settings")
