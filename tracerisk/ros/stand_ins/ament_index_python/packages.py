"""Where packages are: in the workspace their source folders, else where they are installed."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.robot.bring_up.absent_shares import absent_share

_NAME = re.compile(r"[a-zA-Z0-9][a-zA-Z0-9_-]+", re.ASCII)


class PackageNotFoundError(KeyError):
    """There is no such package."""


def get_packages_with_prefixes() -> dict[str, str]:
    """Return the prefix of each package; of one of the workspace it is its folder."""
    return {name: str(_prefix_of(folder)) for name, folder in current().findable.items()}


def get_package_prefix(package_name: str) -> str:
    """Return the prefix of a package; of one of the workspace it is its folder.

    Raises:
        PackageNotFoundError: there is no such package.
        ValueError: the name is none of a package.
    """
    return str(_prefix_of(_folder_of(package_name)))


def _folder_of(package_name: str) -> Path:
    """Return the folder that holds a package's files."""
    if _NAME.fullmatch(package_name) is None:
        raise ValueError(f"'{package_name}' is not a valid package name")
    packages = current().findable
    if package_name not in packages:
        absent = absent_share(package_name, current())
        if absent is not None:
            return absent
        raise PackageNotFoundError(
            f"package '{package_name}' not found, searching: {current().searched}"
        )
    return packages[package_name]


def _prefix_of(folder: Path) -> Path:
    return folder.parent.parent if folder.parent.name == "share" else folder


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:
    """Return the folder that holds a package's files; see `get_package_prefix`."""
    return str(_folder_of(package_name))


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:
    """Return the folder that holds a package's files; see `get_package_prefix`."""
    return _folder_of(package_name)
