"""Screw axes and home poses of the arms; see `interbotix_xs_modules.mr_descriptions`."""

from .. import mr_descriptions as _of_ros1
from ..mr_descriptions import *  # noqa: F403 - each name of it

__all__ = list(_of_ros1.__all__)
