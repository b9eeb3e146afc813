"""Names: what the node is called, and how it resolves and remaps the names it uses."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from tracerisk.ros.graph import graph_names

from ._node import node
from .exceptions import ROSException, ROSInitException
from .impl.validators import ParameterInvalid

SEP = graph_names.SEP
GLOBALNS = graph_names.SEP
PRIV_NAME = graph_names.PRIVATE
REMAP = graph_names.REMAP
ANYTYPE = graph_names.ANY_TYPE
TOPIC_ANYTYPE = graph_names.ANY_TYPE
SERVICE_ANYTYPE = graph_names.ANY_TYPE

canonicalize_name = graph_names.canonical
is_global = graph_names.is_global
is_private = graph_names.is_private
is_legal_name = graph_names.is_legal_name
is_legal_remap = graph_names.is_legal_remap
load_mappings = graph_names.load_mappings
make_global_ns = graph_names.make_global
namespace = graph_names.namespace
ns_join = graph_names.join


def _warn_unless_legal(name: str, stacklevel: int) -> None:
    """Warn of a name that other tools may not take, at the line that is so many calls above."""
    if not is_legal_name(name):
        warnings.warn(
            f"'{name}' is not a legal ROS graph resource name. "
            "This may cause problems with other ROS tools",
            stacklevel=stacklevel + 1,
        )


def isstring(s: Any) -> bool:
    """Return whether `s` is a string."""
    return isinstance(s, str)


def get_name() -> str:
    """Return the full name of this node."""
    return node().name


get_caller_id = get_name


def _set_caller_id(caller_id: str) -> None:
    """Give this node a resolved name, as programs do that test names."""
    node().set_name(caller_id)


def get_namespace() -> str:
    """Return the namespace of this node, with a trailing slash."""
    return node().namespace


def get_mappings() -> dict[str, str]:
    """Return the remappings of the command line as they were given."""
    return node().mappings


def get_resolved_mappings() -> dict[str, str]:
    """Return the remappings of the command line between resolved names."""
    return node().resolved_mappings


def reload_mappings(argv: list[str]) -> None:
    """Take the remappings from another command line."""
    node().mappings = graph_names.load_mappings(argv)


def initialize_mappings(node_name: str) -> None:
    """Resolve the remappings for a node's name."""
    node().set_name(node_name)


def resolve_name(name: str, caller_id: str | None = None) -> str:
    """Return the global name for `name`, remapped, as this node or `caller_id` says it."""
    state = node()
    return graph_names.resolve(
        str(name) if name else "", caller_id or state.name, state.resolved_mappings
    )


def resolve_name_without_node_name(name: str) -> str:
    """Return the global name for `name` before the node has one.

    Raises:
        ValueError: the name is private.
        ROSInitException: it is remapped to a private name.
    """
    if is_private(name):
        raise ValueError("~name topics cannot be created before init_node() has been called")
    state = node()
    fake = graph_names.join(state.namespace, "node")
    resolved = graph_names.resolve(name, fake)
    for old, new in state.mappings.items():
        if graph_names.resolve(old, fake) == resolved:
            if is_private(new):
                raise ROSInitException(
                    f"{name} cannot be remapped to a ~name before init_node() has been called"
                )
            return graph_names.resolve(new, fake)
    return resolved


def remap_name(name: str, caller_id: str | None = None, resolved: bool = True) -> str:
    """Return what `name` is remapped to, resolved; a name that is not remapped stays as it is."""
    state = node()
    if name in state.mappings:
        return graph_names.resolve(state.mappings[name], caller_id or state.name)
    return name


def scoped_name(caller_id: str, name: str) -> str:
    """Return a name relative to the namespace of `caller_id`.

    Raises:
        ROSException: `caller_id` is not global.
    """
    if not is_global(caller_id):
        raise ROSException("caller_id must be global")
    return canonicalize_name(name)[len(namespace(caller_id)) :]


Validator = Callable[[Any, str], str]
"""A check of an argument that the caller of a name gives: it returns what it stands for."""


def valid_name_validator_resolved(param_name: str, param_value: Any, caller_id: str) -> str:
    """Return the global name for an argument as `caller_id` says it, not remapped.

    Raises:
        ParameterInvalid: it is empty, no string, or has a colon or a space.
    """
    plain = valid_name_validator_unresolved(param_name, param_value, caller_id)
    return graph_names.resolve(plain, caller_id)


def valid_name_validator_unresolved(param_name: str, param_value: Any, caller_id: str) -> str:
    """Return an argument that is a name, as it is.

    Raises:
        ParameterInvalid: it is empty, no string, or has a colon or a space.
    """
    _check_string(param_name, param_value)
    if ":" in param_value or " " in param_value:
        raise ParameterInvalid(f"ERROR: parameter [{param_name}] contains illegal chars")
    return str(param_value)


def valid_name(param_name: str, resolve: bool = True) -> Validator:
    """Return a check of a name, which it resolves if `resolve`."""
    check = valid_name_validator_resolved if resolve else valid_name_validator_unresolved
    return lambda param_value, caller_id: check(param_name, param_value, caller_id)


def global_name(param_name: str) -> Validator:
    """Return a check of a name that must be global."""

    def validator(param_value: Any, caller_id: str) -> str:
        _check_string(param_name, param_value)
        if not is_global(param_value):
            raise ParameterInvalid(
                f"ERROR: parameter [{param_name}] must be a globally referenced name"
            )
        return str(param_value)

    return validator


def _check_string(param_name: str, param_value: Any) -> None:
    if not param_value or not isstring(param_value):
        raise ParameterInvalid(f"ERROR: parameter [{param_name}] must be a non-empty string")
