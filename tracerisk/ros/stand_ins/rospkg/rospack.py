"""Packages by name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.robot.bring_up.absent_shares import absent_share

from .common import PACKAGE_FILE, ResourceNotFound
from .manifest import Manifest, parse_manifest_file

# Within the class, `list` is a method of it.
Names = list[str]


class RosPack:
    """The packages of the workspace and the installed ones, or of those below `ros_paths`."""

    def __init__(self, ros_paths: Sequence[str] | None = None) -> None:
        self._folders = dict(current().findable)
        if ros_paths is not None:
            tops = [Path(path).resolve() for path in ros_paths]
            self._folders = {
                name: folder
                for name, folder in self._folders.items()
                if any(folder.resolve().is_relative_to(top) for top in tops)
            }
        self._ros_paths = get_ros_paths() if ros_paths is None else list(ros_paths)

    @classmethod
    def get_instance(cls, ros_paths: Sequence[str] | None = None) -> RosPack:
        """Return the packages, as the constructor does."""
        return cls(ros_paths)

    @property
    def ros_paths(self) -> list[str]:
        """The folders that are looked in."""
        return list(self._ros_paths)

    def get_ros_paths(self) -> list[str]:
        """Return the folders that are looked in."""
        return self.ros_paths

    def list(self) -> list[str]:
        """Return the names of all packages."""
        return list(self._folders)

    def get_path(self, name: str) -> str:
        """Return the folder of a package.

        Raises:
            ResourceNotFound: there is no such package.
        """
        if name not in self._folders:
            absent = absent_share(name, current())
            if absent is not None:
                return str(absent)
            raise ResourceNotFound(name, self._ros_paths)
        return str(self._folders[name])

    def get_manifest(self, name: str) -> Manifest:
        """Return what a package says of itself.

        Raises:
            ResourceNotFound: there is no such package.
            InvalidManifest: its manifest is malformed.
        """
        return parse_manifest_file(self.get_path(name))

    def get_depends(self, name: str, implicit: bool = True) -> Names:
        """Return the packages of the workspace that a package needs, indirectly too if `implicit`.

        Raises:
            ResourceNotFound: there is no such package.
        """
        table: dict[str, None] = {}
        waiting = [name]
        while waiting:
            for depend in self.get_manifest(waiting.pop(0)).depends:
                if (
                    depend.name in self._folders
                    and depend.name not in table
                    and depend.name != name
                ):
                    table[depend.name] = None
                    if implicit:
                        waiting.append(depend.name)
        return [*table]

    def get_depends_on(self, name: str, implicit: bool = True) -> Names:
        """Return the packages of the workspace that need a package."""
        return [folder for folder in self._folders if name in self.get_depends(folder, implicit)]


def get_package_name(path: str) -> str | None:
    """Return the name of the package that a path lies in, or None."""
    start = Path(path).resolve()
    for folder in (start, *start.parents):
        if (folder / PACKAGE_FILE).is_file():
            return parse_manifest_file(str(folder)).name
    return None


def get_ros_paths(env: object = None) -> list[str]:
    """Return the folders that hold the packages of the workspace."""
    return sorted({str(folder.parent) for folder in current().findable.values()})


def get_ros_package_path(env: object = None) -> str:
    """Return the folders that hold the packages of the workspace, joined by colons."""
    return ":".join(get_ros_paths())


def get_ros_root(env: object = None) -> str | None:
    """Return where ROS is installed: nowhere."""
    return None
