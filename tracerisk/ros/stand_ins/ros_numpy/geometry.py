"""As `ros2_numpy.geometry`."""

from ros2_numpy.geometry import *  # noqa: F403
