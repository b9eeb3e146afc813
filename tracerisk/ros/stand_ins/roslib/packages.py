"""Where packages are, and what lies in them."""

from __future__ import annotations

import os
from pathlib import Path

from rospkg import ResourceNotFound, RosPack, get_package_name


class ROSPkgException(Exception):
    """Something is wrong with a package."""


class InvalidROSPkgException(ROSPkgException):
    """A package is not there."""


def get_pkg_dir(package: str, required: bool = True, ros_root: object = None) -> str | None:
    """Return the folder of a package; None if it is not there and not `required`.

    Raises:
        InvalidROSPkgException: it is not there.
    """
    try:
        return str(RosPack().get_path(package))
    except ResourceNotFound as error:
        if required:
            raise InvalidROSPkgException(f"Cannot locate installation of package {error}") from None
        return None


def get_dir_pkg(d: str) -> tuple[str | None, str | None]:
    """Return folder and name of the package that a path lies in, or twice None."""
    name = get_package_name(d)
    return (None, None) if name is None else (get_pkg_dir(name, required=False), name)


def list_pkgs(environ: object = None) -> list[str]:
    """Return the names of all packages."""
    names: list[str] = RosPack().list()
    return names


def find_resource(
    pkg: str, resource_name: str, filter_fn: object = None, rospack: object = None
) -> list[str]:
    """Return the files of a name in a package.

    Raises:
        ResourceNotFound: the package is not there.
    """
    top = Path(RosPack().get_path(pkg))
    accepts = filter_fn if callable(filter_fn) else lambda path: True
    resource = []
    for folder, folders, files in os.walk(top):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        path = str(Path(folder) / resource_name)
        if resource_name in files and accepts(path):
            resource.append(path)
    return resource


def find_node(pkg: str, node_type: str, rospack: object = None) -> list[str]:
    """Return the programs of a name in a package."""
    return find_resource(pkg, node_type, lambda path: os.access(path, os.X_OK))
