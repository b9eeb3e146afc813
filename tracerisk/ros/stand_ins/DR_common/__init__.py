"""Stand-in for DR_common of Doosan in ROS 1: what DR_common2 is in ROS 2.

Source: doosan-robotics/doosan-robot common/imp/DR_common.py.
"""

# ruff: noqa: F403 - as the library does
from __future__ import annotations

from DR_common2 import *

from tracerisk.ros.imports.exported import exported as _exported

__all__ = _exported(globals())
