# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for interactive_markers: markers that a user drags in RViz, of both ROS."""

from tracerisk.ros.imports.exported import exported as _exported

from .interactive_marker_server import InteractiveMarkerServer
from .menu_handler import MenuHandler

__all__ = _exported(globals(), "interactive_marker_server", "menu_handler")
