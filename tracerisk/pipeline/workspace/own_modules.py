"""The modules of its own project that a controller imports, found without running it."""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Iterator
from pathlib import Path

from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.workspace import find_workspace, project_top
from tracerisk.records import replace

_MOST_MODULES = 100


def own_modules(controller: Controller) -> tuple[Path, ...]:
    """Return the modules below the project's top that the script imports, and these in turn.

    They are in the order in which they are met; what cannot be read or parsed imports nothing.
    """
    top = project_top(controller.root)
    bases = _bases(controller)
    script = controller.path.resolve()
    found: dict[Path, None] = {}
    waiting = list(_imported(_parsed(controller.source), script, bases))
    while waiting and len(found) < _MOST_MODULES:
        path = waiting.pop(0)
        if path in found or path == script or not path.is_relative_to(top):
            continue
        found[path] = None
        waiting += _imported(_parsed(_read(path)), path, bases)
    return tuple(found)


def with_own_modules(controller: Controller) -> Controller:
    """Return the controller with the sources of its own modules behind that of its script.

    For those who look for names of joints, groups and robots in it; it is not the one that runs.
    """
    texts = [_text(controller.source)]
    texts += [_text(source) for source in map(_read, own_modules(controller)) if _parsed(source)]
    # Two lines before it, so that no line is taken for a declaration of the encoding.
    source = "\n\n".join(("", *texts, "")).encode()
    return replace(controller, source=source) if _parsed(source) else controller


def _bases(controller: Controller) -> tuple[Path, ...]:
    """Return the folders in which a build, or Python itself, would look for modules."""
    root = controller.root.resolve()
    workspace = find_workspace(root)
    folders = (
        controller.path.resolve().parent,
        root,
        root / "src",
        *workspace.import_paths,
        *workspace.packages.values(),
    )
    return tuple(dict.fromkeys(folders))


def _imported(tree: ast.Module | None, file: Path, bases: tuple[Path, ...]) -> Iterator[Path]:
    for node in ast.walk(tree) if tree is not None else ():
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield from module_files(alias.name.split("."), bases)
        elif isinstance(node, ast.ImportFrom):
            start = (node.module or "").split(".") if node.module else []
            above = tuple(file.parents)[: node.level]
            where = bases if not node.level else above[-1:]
            yield from module_files(start, where)
            for alias in node.names:
                yield from module_files([*start, alias.name], where)


def module_files(parts: list[str], bases: tuple[Path, ...]) -> Iterator[Path]:
    """Yield the files that are run where a module is imported: those of its packages, and its."""
    for base in bases:
        files = [base.joinpath(*parts[: n + 1], "__init__.py") for n in range(len(parts))]
        if parts:
            files.append(base.joinpath(*parts[:-1], f"{parts[-1]}.py"))
        there = [file for file in files if file.is_file()]
        if there:
            yield from there
            return


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def _parsed(source: bytes) -> ast.Module | None:
    try:
        return ast.parse(source)
    except (SyntaxError, ValueError):
        return None


def _text(source: bytes) -> str:
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(source).readline)
        return source.decode(encoding)
    except (SyntaxError, UnicodeDecodeError):
        return source.decode("utf-8", errors="replace")
