"""Stand-in for tf2_kdl: importing it lets buffers transform vectors and frames of PyKDL."""

from . import tf2_kdl as _module
from .tf2_kdl import *  # noqa: F403 - each name of it

__all__ = list(_module.__all__)
