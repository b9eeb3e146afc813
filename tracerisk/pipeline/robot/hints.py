"""What may name a controller's robot, by its weight: source, comments, paths, project files."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.own_modules import own_modules
from tracerisk.pipeline.workspace.package_folders import PACKAGE_FILE, declared_needs
from tracerisk.pipeline.workspace.sibling_programs import sibling_programs
from tracerisk.pipeline.workspace.workspace import (
    project_top,
    searched,
)
from tracerisk.source.python_source import parsed
from tracerisk.twin.robots.robot_names import Hint

_KINDS = (
    ("the package's manifest", re.compile(r"package\.xml")),
    ("a launch file", re.compile(r".*\.launch(\.py|\.xml|\.yaml)?|.*_launch\.py")),
    ("a parameter file", re.compile(r".*\.ya?ml")),
    ("a readme", re.compile(r"readme(\..*)?", re.IGNORECASE)),
)
_OF_A_ROBOT = re.compile(r"_(moveit_?config|description|support|bringup|gazebo)$")
_MARKS = (PACKAGE_FILE, "pyproject.toml", "setup.py", ".git", "src")
_MOST_FOLDERS = 1000
_MOST_FILES = 200  # of one kind
_MOST_BYTES = 256 * 1024  # of one file


def robot_hints(controller: Controller) -> Iterator[Hint]:
    """Yield what may name the robot, the heaviest first; files are read when they are asked for."""
    name = controller.path.name
    spoken, said = _read(controller.source)
    yield Hint("its source", {name: spoken}, is_telling=True)
    top = project_top(controller.root)
    modules = {
        path.relative_to(top).as_posix(): _read(path.read_bytes())
        for path in own_modules(controller)
    }
    yield Hint("a module of its own", {file: read[0] for file, read in modules.items()}, True)
    yield Hint("its comments", {name: said})
    yield Hint("a module's comments", {file: read[1] for file, read in modules.items()})
    needs = [name for name in declared_needs(controller.root) if _OF_A_ROBOT.search(name)]
    yield Hint("what its package depends on", {PACKAGE_FILE: "\n".join(needs)}, is_telling=True)
    yield from _paths(controller)
    beside = sibling_programs(controller)
    yield Hint("a program beside it", {each.path.name: _read(each.source)[0] for each in beside})
    yield from _project(controller)


def _read(source: bytes) -> tuple[str, str]:
    """Return strings and identifiers of a source, and its comments and docstrings."""
    spoken: list[str] = []
    said: list[str] = []
    tree = parsed(source)
    if tree is None:
        return "", ""
    try:
        said += [
            token.string
            for token in tokenize.tokenize(io.BytesIO(source).readline)
            if token.type == tokenize.COMMENT
        ]
    except (SyntaxError, tokenize.TokenError):
        return "", ""
    docstrings = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.add(id(node.value))
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            (said if id(node) in docstrings else spoken).append(node.value)
        else:
            spoken += _identifiers(node)
    return "\n".join(dict.fromkeys(spoken)), "\n".join(said)


def _identifiers(node: ast.AST) -> Iterator[str]:
    for field in ("id", "attr", "arg", "name", "asname", "module"):
        value = getattr(node, field, None)
        if isinstance(value, str):
            yield value


def _paths(controller: Controller) -> Iterator[Hint]:
    """Yield the file's name, and those of the folders around it up to the project's top."""
    script = controller.path.resolve()
    yield Hint("its file's name", {script.name: script.stem}, is_telling=True)
    top = project_top(controller.root)
    for folder in script.parents if _is_project(controller.root) else ():
        if not folder.is_relative_to(top):
            break
        yield Hint("its folder's name", {folder.name: folder.name}, is_telling=True)


def _project(controller: Controller) -> Iterator[Hint]:
    """Yield the files of the controller's package, then those of the rest of its project."""
    root, top = controller.root.resolve(), project_top(controller.root)
    near = list(_files(root)) if _is_project(root) else sorted(root.iterdir())
    seen = set(near)
    beyond = [file for file in _files(top) if file not in seen] if top != root else []
    for files in (near, beyond):
        for what, pattern in _KINDS:
            chosen = [each for each in files if pattern.fullmatch(each.name)][:_MOST_FILES]
            if chosen:
                yield Hint(what, dict(_texts(chosen, top)))


def _is_project(root: Path) -> bool:
    """Return whether what stands in the root's folder belongs together; a script may lie about."""
    return project_top(root) != root.resolve() or any((root / mark).exists() for mark in _MARKS)


def _files(top: Path) -> Iterator[Path]:
    for folder, files in islice(searched(top), _MOST_FOLDERS):
        yield from (Path(folder, name) for name in files)


def _texts(files: Iterable[Path], top: Path) -> Iterator[tuple[str, str]]:
    for file in files:
        try:
            with file.open("rb") as stream:
                text = stream.read(_MOST_BYTES)
        except OSError:
            continue
        yield file.relative_to(top).as_posix(), text.decode("utf-8", errors="replace")
