"""Stand-in for catkin: where files of packages are."""

from . import find_in_workspaces

__all__ = ["find_in_workspaces"]
