"""Stand-in for ros2_numpy: messages as arrays, and arrays as messages."""

from . import geometry, image, occupancy_grid, point_cloud2
from .registry import msgify, numpify

__all__ = ["geometry", "image", "msgify", "numpify", "occupancy_grid", "point_cloud2"]
