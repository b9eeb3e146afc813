"""Stand-in for ros_numpy: messages as arrays, and arrays as messages."""

from ros2_numpy import geometry, image, msgify, numpify, occupancy_grid, point_cloud2
from rospy.numpy_msg import numpy_msg

__all__ = ["geometry", "image", "msgify", "numpify", "numpy_msg", "occupancy_grid", "point_cloud2"]
