"""Suggest what an unknown name may have meant."""

from __future__ import annotations

from tracerisk.common.hardware.sysml.language.name_resolution import Found, Symbol
from tracerisk.common.hardware.sysml.language.standard_names import Standard, known_members
from tracerisk.common.hardware.sysml.language.syntax import Import, Reference
from tracerisk.errors import one_of

_WHERE = "declare it in this file or in a .sysml file beside it, or read the folder of all files"


def unknown_name(scope: Symbol, target: Reference) -> str:
    """Return what to say of a name that stands for nothing as seen from a scope."""
    name = target.name
    for package in ("TraceriskHardware", "RiskMetadata"):
        if len(name) == 1 and name[0] in known_members((package,)):
            return f"'{target}' is not imported; add 'private import {package}::*;'"
    if len(name) > 1:
        for length in range(len(name) - 1, 0, -1):
            space = scope.qualified(name[:length])
            if space is not None:
                missing = name[length]
                within = "::".join(name[:length])
                known = _names_in(space)
                return f"'{within}' has no '{missing}'; {one_of(known, missing)}"
        return f"unknown package or element '{name[0]}'; {_WHERE}"
    visible: set[str] = set()
    around: Symbol | None = scope
    while around is not None:
        visible.update(member.name for member in around.members if member.name)
        around = around.owner
    if any(isinstance(node, Import) and node.target is target for node in scope.nodes):
        return f"unknown name '{target}'; {_WHERE}; {one_of(visible, name[0])}"
    return f"unknown name '{target}'; declare or import it; {one_of(visible, name[0])}"


def _names_in(space: Found) -> tuple[str, ...]:
    if isinstance(space, Standard):
        return known_members(space.path)
    return tuple(member.name for member in space.members if member.name)
