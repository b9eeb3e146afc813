"""Names of the ROS graph: `/absolute`, `relative`, `~private`, and how they are resolved."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

SEP = "/"
PRIVATE = "~"
REMAP = ":="
ANY_TYPE = "*"

_LEGAL = re.compile(r"[~/A-Za-z][\w/]*", re.ASCII)
_LEGAL_BASE = re.compile(r"[A-Za-z]\w*", re.ASCII)
_LEGAL_REMAP = re.compile(r"([~/A-Za-z]|_|__)[\w/]*:=.*", re.DOTALL)


def is_global(name: str) -> bool:
    """Return whether a name begins at the root."""
    return name.startswith(SEP)


def is_private(name: str) -> bool:
    """Return whether a name is one of the node's own."""
    return name.startswith(PRIVATE)


def is_legal_name(name: str | None) -> bool:
    """Return whether a name may be one of a topic, a service or a parameter."""
    if not name:
        return name == ""
    return _LEGAL.fullmatch(name) is not None and "//" not in name


def is_legal_base_name(name: str | None) -> bool:
    """Return whether a name may be one of a node."""
    return name is not None and _LEGAL_BASE.fullmatch(name) is not None


def is_legal_remap(argument: str | None) -> bool:
    """Return whether a command-line argument is a remapping: `old:=new`, `_parameter:=value`."""
    return argument is not None and _LEGAL_REMAP.fullmatch(argument) is not None


def canonical(name: str) -> str:
    """Return a name without doubled and trailing slashes."""
    if not name or name == SEP:
        return name
    joined = SEP.join(part for part in name.split(SEP) if part)
    return SEP + joined if is_global(name) else joined


def namespace(name: str) -> str:
    """Return the namespace of a name, with a trailing slash: `/arm/` of `/arm/gripper`."""
    trimmed = name.removesuffix(SEP)
    return trimmed[: trimmed.rfind(SEP) + 1] or SEP


def join(space: str, name: str) -> str:
    """Return `name` within a namespace; private and global names stay as they are."""
    if is_private(name) or is_global(name) or not space:
        return name
    if space == PRIVATE or space.endswith(SEP):
        return space + name
    return space + SEP + name


def make_global(name: str) -> str:
    """Return a name as a global namespace with a trailing slash.

    Raises:
        ValueError: the name is private.
    """
    if is_private(name):
        raise ValueError(f"cannot turn [{name}] into a global name")
    absolute = name if is_global(name) else SEP + name
    return absolute if absolute.endswith(SEP) else absolute + SEP


def resolve(name: str, node: str, remappings: Mapping[str, str] | None = None) -> str:
    """Return the global name for `name` as the node `node` says it; an empty one is its namespace.

    `remappings` maps resolved names to resolved names.
    """
    if not name:
        return namespace(node)
    plain = canonical(name)
    if is_global(plain):
        resolved = plain
    elif is_private(plain):
        resolved = canonical(node + SEP + plain[1:])
    else:
        resolved = namespace(node) + plain
    return (remappings or {}).get(resolved, resolved)


def load_mappings(arguments: Sequence[str]) -> dict[str, str]:
    """Return the remappings of a command line, `__name` and its like among them."""
    return {
        old: new
        for old, new in _assignments(arguments)
        if not (len(old) > 1 and old[0] == "_" and old[1] != "_")
    }


def load_parameters(arguments: Sequence[str]) -> dict[str, str]:
    """Return the private parameters of a command line, `_name:=value`, as text."""
    return {
        old[1:]: new
        for old, new in _assignments(arguments)
        if len(old) > 1 and old[0] == "_" and old[1] != "_"
    }


def _assignments(arguments: Sequence[str]) -> list[tuple[str, str]]:
    pairs = []
    for argument in arguments:
        if is_legal_remap(argument):
            old, _, new = argument.partition(REMAP)
            if old.strip() and new.strip():
                pairs.append((old.strip(), new.strip()))
    return pairs
