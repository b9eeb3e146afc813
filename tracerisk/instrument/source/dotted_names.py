"""The names that expressions and imports of Python are written with."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

_UPWARDS = 4  # folders above a source in which the modules that it imports are looked for


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


def imports_in(tree: ast.AST | None) -> tuple[tuple[int, tuple[str, ...]], ...]:
    """Return what a source imports: the level of a relative import, and the parts of a name."""
    imports: list[tuple[int, tuple[str, ...]]] = []
    for node in ast.walk(tree) if tree is not None else ():
        if isinstance(node, ast.Import):
            imports += ((0, tuple(alias.name.split("."))) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = tuple(node.module.split(".")) if node.module else ()
            imports.append((node.level, start))
            # A submodule may be named as what is imported: `from control_msgs import action`.
            imports += ((node.level, (*start, alias.name)) for alias in node.names)
    return tuple(imports)


def imported_names(tree: ast.AST, file: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield what a source imports from files near it: (name here, name there, that file)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.level <= _UPWARDS:
            module_file = _module_file(node.module, node.level, file)
            if module_file is not None:
                yield from (
                    (alias.asname or alias.name, alias.name, module_file) for alias in node.names
                )


def _module_file(module: str, level: int, file: Path) -> Path | None:
    """Return the file of a module that stands beside a source, or in a folder above it."""
    above = file.parents[level - 1 : level] if level else file.parents[:_UPWARDS]
    for folder in above:
        path = folder.joinpath(*module.split(".")).with_suffix(".py")
        if path.is_file() and path != file:
            return path
    return None
