"""Names of ROS 1: legal ones, joined, resolved and remapped ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.ros.graph import names as _names
from tracerisk.ros.graph.runtime import current

SEP = "/"
PRIV_NAME = "~"
GLOBALNS = "/"
ANYTYPE = "*"
REMAP = ":="


def isstring(s: object) -> bool:
    """Return whether it is a text."""
    return isinstance(s, str)


def is_global(name: str) -> bool:
    """Return whether a name begins at the root."""
    return _names.is_global(name)


def is_private(name: str) -> bool:
    """Return whether a name is one within a node's."""
    return _names.is_private(name)


def is_legal_name(name: str | None) -> bool:
    """Return whether a name is one that ROS takes."""
    return _names.is_legal_name(name)


def is_legal_base_name(name: str | None) -> bool:
    """Return whether a name is one that ROS takes, and has no namespace."""
    return _names.is_legal_base_name(name)


def is_legal_remap(arg: str | None) -> bool:
    """Return whether an argument of a command line is a remapping."""
    return _names.is_legal_remap(arg)


def canonicalize_name(name: str) -> str:
    """Return a name without empty parts."""
    return _names.canonical(name)


def namespace(name: str) -> str:
    """Return the namespace of a name, with a slash at its end."""
    return _names.namespace(name)


def ns_join(ns: str, name: str) -> str:
    """Return a name within a namespace; a global or private name as it is."""
    return _names.join(ns, name)


def make_global_ns(name: str) -> str:
    """Return a name that begins and ends with a slash.

    Raises:
        ValueError: it is private.
    """
    return _names.make_global(name)


def resolve_name(name: str, namespace_: str, remappings: Mapping[str, str] | None = None) -> str:
    """Return the full name of one that a node `namespace_` uses."""
    return _names.resolve(name, namespace_, remappings)


def script_resolve_name(script_name: str, name: str) -> str:
    """Return the full name of one that a script without a node uses.

    A private name is one of `script_name`.
    """
    if not name:
        return get_ros_namespace()
    if _names.is_global(name):
        return name
    if _names.is_private(name):
        return _names.join(f"{get_ros_namespace()}{script_name}", name[1:])
    return get_ros_namespace() + name


def get_ros_namespace(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the namespace that the command line (`__ns:=`) or the environment gives."""
    import os

    mappings = load_mappings(list(current().argv) if argv is None else argv)
    found = mappings.get("__ns") or (os.environ if env is None else env).get("ROS_NAMESPACE", SEP)
    return _names.make_global(found)


def load_mappings(argv: Sequence[str]) -> dict[str, str]:
    """Return the remappings of a command line."""
    return _names.load_mappings(argv)


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line without remappings."""
    import rospy

    found: list[str] = rospy.myargv(argv)
    return found
