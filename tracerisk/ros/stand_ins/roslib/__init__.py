"""Stand-in for roslib: the path of a package, and messages by name."""

from . import message, names, packages
from .launcher import load_manifest

__all__ = ["load_manifest", "message", "names", "packages"]
