# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for rospkg: the packages of the controller's workspace."""

from tracerisk.ros.imports.exported import exported as _exported

from .common import MANIFEST_FILE, PACKAGE_FILE, STACK_FILE, ResourceNotFound
from .manifest import InvalidManifest, Manifest, parse_manifest_file
from .rospack import RosPack, get_package_name, get_ros_package_path, get_ros_paths, get_ros_root

__all__ = _exported(globals())
