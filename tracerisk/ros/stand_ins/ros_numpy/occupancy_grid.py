"""As `ros2_numpy.occupancy_grid`."""

from ros2_numpy.occupancy_grid import *  # noqa: F403
