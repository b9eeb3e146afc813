"""Stand-in for ros, of roslib: the packages of ROS as its attributes."""

from __future__ import annotations

import importlib
from types import ModuleType


def __getattr__(name: str) -> ModuleType:
    """Return the Python module of a package: `ros.rospy`, or `from ros import rospy`."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise AttributeError(f"module 'ros' has no attribute {name!r}: {error}") from error
