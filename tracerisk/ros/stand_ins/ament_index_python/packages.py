"""Where packages are: their source folders, for nothing is installed."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.ros.graph.runtime import current

_NAME = re.compile(r"[a-zA-Z0-9][a-zA-Z0-9_-]+", re.ASCII)


class PackageNotFoundError(KeyError):
    """The workspace holds no such package."""


def get_packages_with_prefixes() -> dict[str, str]:
    """Return the folder of each package of the workspace."""
    return {name: str(folder) for name, folder in current().packages.items()}


def get_package_prefix(package_name: str) -> str:
    """Return the folder of a package: its source, for it is installed nowhere.

    Raises:
        PackageNotFoundError: the workspace holds no such package.
        ValueError: the name is none of a package.
    """
    if _NAME.fullmatch(package_name) is None:
        raise ValueError(f"'{package_name}' is not a valid package name")
    packages = current().packages
    if package_name not in packages:
        known = ", ".join(packages) or "none"
        raise PackageNotFoundError(
            f"package '{package_name}' not found, searching: the workspace of the controller, "
            f"which has {known}"
        )
    return str(packages[package_name])


def get_package_share_directory(package_name: str, print_warning: bool = True) -> str:
    """Return the folder that holds a package's files, its source; see `get_package_prefix`."""
    return get_package_prefix(package_name)


def get_package_share_path(package_name: str, print_warning: bool = True) -> Path:
    """Return the folder that holds a package's files; see `get_package_prefix`."""
    return Path(get_package_prefix(package_name))
