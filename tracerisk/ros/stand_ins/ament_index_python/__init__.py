# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for ament_index_python: the packages of the workspace and the installed ones."""

from tracerisk.ros.imports.exported import exported as _exported

from .packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
    get_package_share_path,
    get_packages_with_prefixes,
)
from .resources import get_resource, get_resources, has_resource
from .search_paths import get_search_paths

__all__ = _exported(globals())
