"""As `ros2_numpy.registry`."""

from ros2_numpy.registry import *  # noqa: F403
