"""Which folders belong to a ROS prefix: an installed ROS, or an overlay.

A shell that has sourced one puts folders of it on the paths of Python and of system libraries.
What is compiled there is for real ROS nodes, and no process of ours may import it by chance.
"""

from __future__ import annotations

import os
import sysconfig
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

SHARE = "share"
"""Where a prefix keeps the folders of its packages."""
CATKIN_MARK = ".catkin"
"""The file at the top of a prefix of ROS 1, with the folders of its sources."""
COLCON_PACKAGES = f"{SHARE}/colcon-core/packages"
"""Where colcon keeps one file for each package of a prefix."""
AMENT_INDEX = f"{SHARE}/ament_index/resource_index"
"""Where a prefix of ROS 2 keeps one folder for each kind of resource, with a file for each."""

_MARKS = (AMENT_INDEX, COLCON_PACKAGES, CATKIN_MARK)
# Folders above `opt/rviz_ogre_vendor/lib` and `local/lib/python3.10/dist-packages`.
_ABOVE = 4
_BUILT = "colcon_build.rc"
"""The file that colcon keeps in the folder in which it builds a package."""
_SPACES = ("install", "devel")
_BESIDE_SPACES = ("src", "build")


def is_prefix(folder: Path) -> bool:
    """Return whether a folder is a prefix of ROS by what lies in it."""
    return any(os.path.exists(folder / mark) for mark in _MARKS)  # noqa: PTH110 - it never raises


def belongs_to_ros(path: str) -> bool:
    """Return whether a folder lies in a prefix of ROS or is the one in which a package is built.

    The folders of this interpreter do not, though an environment may be a prefix as well.
    """
    if os.path.realpath(path) in _of_interpreter():
        return False
    folder = Path(path)
    if (folder / _BUILT).exists():
        return True
    return any(map(is_prefix, (folder, *folder.parents[:_ABOVE])))


def without_ros(paths: Iterable[str]) -> list[str]:
    """Return those of the folders that do not belong to ROS."""
    return [path for path in paths if not belongs_to_ros(path)]


@lru_cache(maxsize=1)
def _of_interpreter() -> frozenset[str]:
    names = ("stdlib", "platstdlib", "purelib", "platlib")
    return frozenset(os.path.realpath(sysconfig.get_path(name)) for name in names)


def readable_folders(packages: Iterable[Path]) -> tuple[Path, ...]:
    """Return the fewest folders that hold packages and the files to which these may link.

    Of an installed package it is its prefix: there are hundreds in one. A workspace installs links
    into its own `src` and `build`.
    """
    table: dict[Path, None] = {}
    for folder in packages:
        if folder.parent.name != SHARE:
            table.setdefault(folder)
            continue
        table.update(dict.fromkeys(prefix_folders(folder.parent.parent)))
    return tuple(table)


def prefix_folders(prefix: Path) -> tuple[Path, ...]:
    """Return a prefix and the folders of its workspace to which it may link."""
    spaces = [path for path in (prefix, prefix.parent) if path.name in _SPACES]
    beside = (space.parent / name for space in spaces[:1] for name in _BESIDE_SPACES)
    return (prefix, *(path for path in beside if path.is_dir()))
