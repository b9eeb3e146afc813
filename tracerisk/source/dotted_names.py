"""The names that expressions and imports of Python are written with."""

from __future__ import annotations

import ast
from collections.abc import Iterator


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


def imports_in(tree: ast.AST | None) -> Iterator[tuple[int, list[str]]]:
    """Yield what a source imports: the level of a relative import, and the parts of a name."""
    for node in ast.walk(tree) if tree is not None else ():
        if isinstance(node, ast.Import):
            yield from ((0, alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = node.module.split(".") if node.module else []
            yield node.level, start
            # A submodule may be named as what is imported: `from control_msgs import action`.
            yield from ((node.level, [*start, alias.name]) for alias in node.names)
