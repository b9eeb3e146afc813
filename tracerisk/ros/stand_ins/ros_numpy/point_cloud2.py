"""As `ros2_numpy.point_cloud2`."""

from ros2_numpy.point_cloud2 import *  # noqa: F403
