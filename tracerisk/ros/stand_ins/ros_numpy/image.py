"""As `ros2_numpy.image`."""

from ros2_numpy.image import *  # noqa: F403
