"""What may name a controller's robot, by its weight: source, comments, paths, project files."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes, in_folder, regular_file
from tracerisk.config import PACKAGE_FILE, controller_root
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.own_modules import imported_directly, own_modules
from tracerisk.pipeline.workspace.package_folders import declared_needs
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.sibling_programs import sibling_programs
from tracerisk.pipeline.workspace.workspace import searched
from tracerisk.twin.robots.robot_names import Hint

_KINDS = (
    ("the package's manifest", re.compile(re.escape(PACKAGE_FILE))),
    ("a launch file", re.compile(r".*\.launch(\.py|\.xml|\.yaml)?|.*_launch\.py")),
    ("a parameter file", re.compile(r".*\.ya?ml")),
    ("a readme", re.compile(r"readme(\..*)?", re.IGNORECASE)),
)
_TEXT = re.compile(r"readme(\..*)?|.*\.(md|rst)", re.IGNORECASE)
_STARTS = re.compile(r"\b(?:roslaunch|rosrun|ros2\s+(?:launch|run))\s")
_OF_A_ROBOT = re.compile(r"_(moveit_?config|description|support|bringup|gazebo)$")
_DEPENDS = re.compile(r"<\w*depend\b[^<]*</\w*depend>")
_ROBOTS = "robots"  # the package with a module a robot in AndrejOrsula/pymoveit2
_MARKS = (PACKAGE_FILE, "pyproject.toml", "setup.py", ".git", "src")
_MOST_FOLDERS = 1000
_MOST_FILES = 200  # of one kind
_MOST_BYTES = 256 * 1024  # of one file


def source_hints(controller: Controller) -> Iterator[Hint]:
    """Yield what of a controller's imports and own source may name the robot."""
    own = _read(controller.source, controller.project.tree)
    yield from _of_source(controller, own, _names_of(imported_directly(controller)))


def robot_hints(controller: Controller) -> Iterator[Hint]:
    """Yield what may name the robot, the heaviest first; files are read when they are asked for."""
    name, tree = controller.path.name, controller.project.tree
    own = _read(controller.source, tree)
    direct = imported_directly(controller)
    known = _names_of(direct)
    yield from _of_source(controller, own, known)
    top, package = controller.project.top, controller_root(controller.path).resolve()
    modules = {path: _read(file_bytes(path), tree) for path in own_modules(controller)}
    near = [path for path in modules if path not in direct and controller_root(path) == package]
    for what, paths in (("a module of its own", direct), ("a module of its package", near)):
        spoken = {path.relative_to(top).as_posix(): modules[path].spoken for path in sorted(paths)}
        yield Hint(what, spoken)
    others = "\n".join(text for text in own.imported if text not in known)
    yield Hint("a library that it imports", {name: others})
    needs = [name for name in declared_needs(controller.root) if _OF_A_ROBOT.search(name)]
    yield Hint("what its package depends on", {PACKAGE_FILE: "\n".join(needs)})
    yield from _paths(controller)
    yield Hint("its comments or docstrings", {name: own.said})
    said = {path.relative_to(top).as_posix(): modules[path].said for path in sorted(direct)}
    yield Hint("a module's comments or docstrings", said)
    beside = sibling_programs(controller)
    said = {item.path.name: _read(item.source, tree).spoken for item in beside}
    yield Hint("a program beside it", said)
    yield from _project(controller)


def _of_source(controller: Controller, own: _Read, known: Collection[str]) -> Iterator[Hint]:
    name = controller.path.name
    yield Hint("its imports", {name: "\n".join(text for text in own.imported if text in known)})
    yield Hint("its import from modules of robots", {name: "\n".join(_of_robots(controller))})
    yield Hint("its source", {name: own.spoken})


def _names_of(modules: Iterable[Path]) -> frozenset[str]:
    """Return how imports may name modules: by their files, and by the packages that hold them."""
    return frozenset(part for path in modules for part in (path.stem, path.parent.name))


def _of_robots(controller: Controller) -> Iterator[str]:
    """Yield the modules that are imported from a package of robots: `pymoveit2.robots.panda`."""
    for _, parts in controller.project.imports(controller.source):
        if _ROBOTS in parts[:-1]:
            yield parts[-1]


@dataclass(frozen=True, slots=True)
class _Read:
    """What a source says, by how much it weighs."""

    imported: tuple[str, ...] = ()
    """The names in its imports, each part of a dotted one."""
    spoken: str = ""
    """Its strings and identifiers."""
    said: str = ""
    """Its comments and docstrings."""


def _read(source: bytes, tree_of: Callable[[bytes], ast.Module | None]) -> _Read:
    imported: list[str] = []
    spoken: list[str] = []
    said: list[str] = []
    tree = tree_of(source)
    if tree is None:
        return _Read()
    try:
        said += [
            token.string
            for token in tokenize.tokenize(io.BytesIO(source).readline)
            if token.type == tokenize.COMMENT
        ]
    except (SyntaxError, tokenize.TokenError):
        return _Read()
    docstrings = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.add(id(node.value))
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            (said if id(node) in docstrings else spoken).append(node.value)
        elif isinstance(node, ast.alias | ast.ImportFrom):
            imported += [part for name in _identifiers(node) for part in name.split(".")]
        else:
            spoken += _identifiers(node)
    return _Read(tuple(imported), "\n".join(dict.fromkeys(spoken)), "\n".join(said))


def _identifiers(node: ast.AST) -> Iterator[str]:
    for field in ("id", "attr", "arg", "name", "asname", "module"):
        value = getattr(node, field, None)
        if isinstance(value, str):
            yield value


def _paths(controller: Controller) -> Iterator[Hint]:
    """Yield the file's name, and those of the folders around it up to the project's top."""
    script = controller.path.resolve()
    yield Hint("its file's name", {script.name: script.stem})
    for name in folders_around(controller):
        yield Hint("its folder's name", {name: name})


def folders_around(controller: Controller) -> Iterator[str]:
    """Yield the names of the folders around a controller, up to the top of its project."""
    top = controller.project.top
    for folder in controller.path.resolve().parents if _is_project(controller.project) else ():
        if not folder.is_relative_to(top):
            break
        yield folder.name


def _project(controller: Controller) -> Iterator[Hint]:
    """Yield the files of the controller's package, then those of the rest of its project."""
    root, top = controller.root.resolve(), controller.project.top
    near = list(_files(root)) if _is_project(controller.project) else in_folder(root)
    seen = set(near)
    beyond = [file for file in _files(top) if file not in seen] if top != root else []
    for files in (near, beyond):
        read = [file for file in files if _TEXT.fullmatch(file.name)][:_MOST_FILES]
        commands = {name: _commands(text) for name, text in _texts(read, top)}
        yield Hint("a command of a readme", commands, has_lines=True)
        for what, pattern in _KINDS:
            chosen = [path for path in files if pattern.fullmatch(path.name)][:_MOST_FILES]
            if chosen:
                yield Hint(what, dict(_texts(chosen, top)), has_lines=True)


def _commands(text: str) -> str:
    """Return the lines that start programs, with those that go on behind a backslash.

    The others are empty, so that the lines keep their numbers.
    """
    kept: list[str] = []
    goes_on = False
    for line in text.splitlines():
        is_kept = goes_on or bool(_STARTS.search(line))
        goes_on = is_kept and line.rstrip().endswith("\\")
        kept.append(line if is_kept else "")
    return "\n".join(kept)


def _is_project(project: Project) -> bool:
    """Return whether what stands in the root's folder belongs together; a script may lie about."""
    root = project.root.resolve()
    return project.top != root or any((root / mark).exists() for mark in _MARKS)


def _files(top: Path) -> Iterator[Path]:
    for folder, files in islice(searched(top), _MOST_FOLDERS):
        yield from (Path(folder, name) for name in files)


def _texts(files: Iterable[Path], top: Path) -> Iterator[tuple[str, str]]:
    for file in files:
        try:
            with regular_file(file) as stream:
                text = stream.read(_MOST_BYTES)
        except OSError:
            continue
        said = text.decode("utf-8", errors="replace")
        if file.name == PACKAGE_FILE:
            said = _DEPENDS.sub("", said)  # which is weighed by itself
        yield file.relative_to(top).as_posix(), said
