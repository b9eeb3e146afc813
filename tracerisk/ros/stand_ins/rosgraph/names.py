"""Names of ROS 1: legal ones, joined, resolved and remapped ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.ros.graph import graph_names as _names
from tracerisk.ros.graph.runtime import current

SEP = "/"
PRIV_NAME = "~"
GLOBALNS = "/"
ANYTYPE = "*"
REMAP = ":="

is_global = _names.is_global
is_private = _names.is_private
is_legal_name = _names.is_legal_name
is_legal_base_name = _names.is_legal_base_name
canonicalize_name = _names.canonical
namespace = _names.namespace
make_global_ns = _names.make_global


def isstring(s: object) -> bool:
    """Return whether it is a text."""
    return isinstance(s, str)


def is_legal_remap(arg: str | None) -> bool:
    """Return whether an argument of a command line is a remapping."""
    return _names.is_legal_remap(arg)


def ns_join(ns: str, name: str) -> str:
    """Return a name within a namespace; a global or private name as it is."""
    return _names.join(ns, name)


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


def make_caller_id(name: str) -> str:
    """Return the name by which a script calls the master, with a `/` at its end."""
    return make_global_ns(ns_join(get_ros_namespace(), name))


def get_ros_namespace(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the namespace that the command line (`__ns:=`) or the environment gives."""
    import os

    mappings = load_mappings(list(current().argv) if argv is None else argv)
    mapping = mappings.get("__ns") or (os.environ if env is None else env).get("ROS_NAMESPACE", SEP)
    return _names.make_global(mapping)


def load_mappings(argv: Sequence[str]) -> dict[str, str]:
    """Return the remappings of a command line."""
    return _names.load_mappings(argv)


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line without remappings."""
    import rospy

    names: list[str] = rospy.myargv(argv)
    return names
