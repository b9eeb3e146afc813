# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for intera_motion_interface: ways through points, for Sawyer's motion controller."""

from tracerisk.ros.imports.exported import exported as _exported

from .trajectory import MotionTrajectory
from .waypoint import MotionWaypoint, MotionWaypointOptions

__all__ = _exported(globals())
