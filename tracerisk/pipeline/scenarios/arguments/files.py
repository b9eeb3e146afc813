"""Files that a command line names: which arguments are files, and what there is to name."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterable
from pathlib import Path

from tracerisk.config import PACKAGE_FILE
from tracerisk.pipeline.workspace.workspace import searched

_READ = re.compile(
    r"(^|[-_])(file|path|filename|csv|ya?ml|json|bag|urdf)s?(name|path)?$", re.IGNORECASE
)
_WRITTEN = re.compile(
    r"(^|[-_])(out(put)?|save|write|record|log|dest(ination)?)([-_]|$)", re.IGNORECASE
)
_OF_FILES = frozenset({"FileType", "Path", "open"})
_SUFFIX = re.compile(r"\.(csv|ya?ml|json|txt|np[yz]|pkl|bag|urdf|xml|gcode|nc|ngc|dxf|svg|stl)\b")
_READERS = {"csv": (".csv",), "json": (".json",), "yaml": (".yaml", ".yml"), "pickle": (".pkl",)}
_NOT_DATA = frozenset({PACKAGE_FILE, "plugin.xml", "CMakeLists.txt", "requirements.txt"})
_MOST = 3


def is_read(names: Iterable[str], type_name: str) -> bool:
    """Return whether an argument of these names, metavar included, is a file that is read."""
    plain = [name.strip("-") for name in names]
    if any(_WRITTEN.search(name) for name in plain):
        return False
    return type_name in _OF_FILES or any(_READ.search(name) for name in plain)


def fitting_files(tree: ast.AST, top: Path) -> tuple[str, ...]:
    """Return the files below `top` of the kinds that a source speaks of, those in data folders too.

    By the endings in its texts and by the readers that it imports; from the current folder.
    """
    endings: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            endings |= {f".{text}" for text in _SUFFIX.findall(node.value)}
        for name in _imported(node):
            endings |= set(_READERS.get(name, ()))
    paths: list[Path] = []
    for folder, files in searched(top) if endings else ():
        paths += [
            Path(folder, name)
            for name in files
            if Path(name).suffix in endings and name not in _NOT_DATA
        ]
    return tuple(os.path.relpath(path) for path in paths[:_MOST])


def _imported(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [name.name for name in node.names]
    return [node.module or ""] if isinstance(node, ast.ImportFrom) else []
