"""What every run loads before its controller's first line, which a server of runs does once."""

from __future__ import annotations

import contextlib
from importlib import import_module

from tracerisk.ros.imports.finder import read_stand_ins
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.vendors.driver_search import shipped_drivers
from tracerisk.twin.physics.scene import load_scene, scene_names

_EVERY_RUN = ("dm_control.mujoco", "numpy.random")
_MESSAGES = "moveit_msgs"
"""The package whose definitions most runs read: they are parsed once."""
_LIBRARIES = ("actionlib", "moveit_commander", "rclpy", "rospy")
"""The libraries whose code most runs read."""


def prepare() -> None:
    """Load what a run of either ROS loads; it is called in no process that runs a controller."""
    for name in _EVERY_RUN:
        # As in the run itself, which does without what is not installed.
        with contextlib.suppress(ImportError):
            import_module(name)
    for interfaces in (Interfaces(), Interfaces2()):
        for name in interfaces.message_names(_MESSAGES):
            interfaces.message(f"{_MESSAGES}/{name}")
    shipped_drivers()
    read_stand_ins(*_LIBRARIES)
    for name in scene_names():
        load_scene(name)
