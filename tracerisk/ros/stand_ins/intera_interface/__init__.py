# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for intera_interface: Sawyer's limb, gripper, head and devices, over the graph."""

from tracerisk.ros.imports.exported import exported as _exported

from . import settings
from .camera import Cameras
from .devices import Cuff, Lights, Navigator
from .gripper import Gripper, SimpleClickSmartGripper, get_current_gripper_interface
from .head import Head, HeadDisplay
from .limb import Limb
from .robot_enable import RobotEnable
from .robot_params import RobotParams
from .settings import (
    CHECK_VERSION,
    HEAD_PAN_ANGLE_TOLERANCE,
    JOINT_ANGLE_TOLERANCE,
    SDK_VERSION,
    VERSIONS_SDK2GRIPPER,
    VERSIONS_SDK2ROBOT,
)

__all__ = _exported(globals(), "settings")
