# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for rosbag2_py: messages recorded in bags of ROS 2 and read from them (db3, MCAP)."""

from tracerisk.ros.imports.exported import exported as _exported

from ._bag import SequentialReader, SequentialWriter
from ._description import *  # noqa: F403 - each name of it

__all__ = _exported(globals())
