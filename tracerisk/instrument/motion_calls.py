"""Which calls of a controller command motion: known by their names, or seen to do so in the run."""

from __future__ import annotations

import ast
from collections.abc import Collection

from tracerisk.instrument.tracer import Site

MOTION_CALLS = frozenset(
    {"go", "execute", "execute_and_wait", "pick", "place"}
    | {"send_goal", "send_goal_async", "send_goal_and_wait"}
)
"""Last names of calls that command motion: those of move groups and of action clients."""

# What so many things have that only the same expression says the same.
_COMMON = frozenset({"publish", "call", "call_async", "send_request"})


def calls_at(source: bytes, sites: Collection[Site]) -> frozenset[str]:
    """Return the names of the calls at some places of a source, as a call graph tells them.

    Each is told as it is written (`self.pub.publish`), and by its last name too where that is
    not one that other calls have as well. A call of what is no plain name is left out.
    """
    wanted = set(sites)
    names: set[str] = set()
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return frozenset()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (node.lineno, node.col_offset + 1) in wanted:
            written = _dotted(node.func)
            if written is None:
                continue
            names.add(written)
            last = written.rpartition(".")[2]
            if isinstance(node.func, ast.Attribute) and last not in _COMMON:
                names.add(last)
    return frozenset(names)


def _dotted(node: ast.expr) -> str | None:
    """Return `a.b.c` as it is written, None for what is more than names and dots."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return None
    return ".".join(reversed([*parts, node.id]))
