"""The names that expressions of Python are written with."""

from __future__ import annotations

import ast


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
