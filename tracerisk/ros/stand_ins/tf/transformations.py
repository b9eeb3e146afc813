"""Matrices (4, 4), quaternions (x, y, z, w) and Euler angles."""

from tracerisk.ros import homogeneous as _homogeneous
from tracerisk.ros.homogeneous import *  # noqa: F403 - each name of it, as the real library has

__all__ = list(_homogeneous.__all__)
