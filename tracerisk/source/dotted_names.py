"""The names that expressions and imports of Python are written with."""

from __future__ import annotations

import ast
from functools import lru_cache


def dotted_name(node: ast.AST) -> str:
    """Return a name with all its parts, as `a.b.c`; empty for what is none."""
    if isinstance(node, ast.Attribute):
        inner = dotted_name(node.value)
        return f"{inner}.{node.attr}" if inner else ""
    return node.id if isinstance(node, ast.Name) else ""


def last_name(node: ast.AST | None) -> str:
    """Return the last part of a dotted name; empty for what is none."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


@lru_cache(maxsize=32)  # several stages of a run ask it of the same trees
def imports_in(tree: ast.AST | None) -> tuple[tuple[int, tuple[str, ...]], ...]:
    """Return what a source imports: the level of a relative import, and the parts of a name."""
    found: list[tuple[int, tuple[str, ...]]] = []
    for node in ast.walk(tree) if tree is not None else ():
        if isinstance(node, ast.Import):
            found += ((0, tuple(alias.name.split("."))) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = tuple(node.module.split(".")) if node.module else ()
            found.append((node.level, start))
            # A submodule may be named as what is imported: `from control_msgs import action`.
            found += ((node.level, (*start, alias.name)) for alias in node.names)
    return tuple(found)
