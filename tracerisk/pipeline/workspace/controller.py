"""The controller: its script, its root, its bytes."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, TraceRiskError, readable
from tracerisk.instrument.source.function_definitions import function_at
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.workspace.project import Project

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from tracerisk.instrument.source.ros_version import RosVersion
    from tracerisk.pipeline.workspace.workspace import Workspace

# What catkin writes for a script of a `devel` space: ros/catkin cmake/templates/script.py.in.
_RELAY = (
    rb"^# generated from catkin/cmake/template/script\.py\.in$[^\0]*?"
    rb"^python_script = '([^'\n]+)'$"
)
# What setuptools writes for an entry point of a package that colcon builds:
# pypa/setuptools setuptools/command/easy_install.py (`ScriptWriter.template`).
_ENTRY = rb"^# EASY-INSTALL-(?:ENTRY-)?SCRIPT: '([^'\n]+)','console_scripts','([^'\n]+)'$"
_PYTHON_LINE = rb"(?:\xef\xbb\xbf)?#![^\n]*python"


def from_root(root: Path, path: Path) -> str:
    """Return a path as seen from a controller's root, with forward slashes.

    What has nothing in common with the root, such as an installed ROS, keeps its full path.
    """
    if path.is_absolute() and len(path.parts) > 1 and path.parts[1:2] != root.resolve().parts[1:2]:
        return path.as_posix()
    return Path(os.path.relpath(path, root)).as_posix()


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller: its script, and the project that this belongs to."""

    path: Path
    """The script, as messages call it."""
    project: Project
    """The project around it."""
    file: str
    """Its name below the root of the project, with forward slashes."""
    source: bytes
    """The bytes of the script."""
    others: Mapping[str, bytes] = field(default_factory=dict)
    """Files of it, by their names below the root, that count so, whatever they hold on disk."""

    @property
    def root(self) -> Path:
        """The folder of its own sources."""
        return self.project.root

    @property
    def settings(self) -> Settings:
        """Its settings, as its files give them. Raises SettingsError."""
        return self.project.settings(self.file)

    def settings_with(self, options: Mapping[str, Any] | None) -> Settings:
        """Return its settings, overridden by the options that are given. Raises SettingsError."""
        return self.settings.with_options(options or {})

    @property
    def tree(self) -> ast.Module | None:
        """The tree of the script, which nobody may change; `None` where it is no Python 3."""
        return self.project.tree(self.source)

    @property
    def ros_version(self) -> RosVersion:
        """For which ROS it is written."""
        return self.project.ros_version(self.path)

    @property
    def workspace(self) -> Workspace:
        """The packages around it, of its own ROS where several have one name."""
        return self.project.workspace(self.ros_version)

    @property
    def is_python(self) -> bool:
        """Whether it is a Python program, not one of C or C++."""
        return not is_c(self.file)

    @property
    def live_words(self) -> str:
        """What a command that runs it has behind its file: nothing where it is Python."""
        return "" if self.is_python else " --live -- COMMAND"

    def path_of(self, file: str) -> Path:
        """Return the path of one of the controller's files, as messages call it."""
        if file == self.file:
            return self.path
        path = self.root.resolve() / file
        return path if self.path.is_absolute() else Path(os.path.relpath(path))

    def source_of(self, file: str) -> bytes:
        """Return the bytes of one of the controller's files, named below the root.

        Raises InputError when it cannot be read.
        """
        if file == self.file:
            return self.source
        if file in self.others:
            return self.others[file]
        path = self.path_of(file)
        with readable(path):
            return file_bytes(path)

    def as_ran(self, sources: Mapping[str, bytes]) -> Controller:
        """Return the controller with the sources that a run compiled, by their names."""
        return replace(self, source=sources.get(self.file, self.source), others=sources)


def lines_since(sources: Mapping[str, bytes], controller: Controller) -> Callable[[str, int], int]:
    """Return what maps a file and a line of it in `sources` to the controller's line now.

    Only blocks may differ: another run may have written them meanwhile. A file that is gone by
    now keeps its lines, for the run itself may have made it.
    Raises InputError where more differs, for then what ran is another program.
    """
    # The process that runs a controller reads no block.
    from tracerisk.adder.sources.insert import strip_blocks
    from tracerisk.adder.sources.line_map import line_maps

    shown = {file: str(controller.path_of(file)) for file in sources}
    now = {
        file: controller.source_of(file)
        for file in sources
        if file == controller.file or Path(shown[file]).is_file()
    }
    before = {file: sources[file] for file in now if now[file] != sources[file]}
    for file, source in before.items():
        if strip_blocks(source, shown[file]) != strip_blocks(now[file], shown[file]):
            raise InputError(
                "was changed by someone else meanwhile; run the same command again",
                Location(shown[file]),
            )
    return line_maps(before, now, shown)


def load_controller(path: Path | str, project: Project | None = None) -> Controller:
    """Read the controller at `path`; `project` is the one around it, where that is known.

    Raises InputError when there is no such file, or its name is not that of a Python program.
    """
    script = Path(path)
    try:
        source = file_bytes(script)
    except OSError as error:
        raise InputError(
            f"the controller cannot be read: {error.strerror}; name a Python file",
            Location(str(path)),
        ) from error
    is_python = script.suffix in (".py", ".pyw") or re.match(_PYTHON_LINE, source)
    if not is_python and not is_c(script.name):
        raise InputError(
            "is neither a Python nor a C or C++ program by its name: a controller ends in .py, "
            ".c, .cpp and the like, or begins with a line such as `#!/usr/bin/env python3`",
            Location(str(path)),
        )
    _forbid_made(source, str(path))
    project = project or Project.of(script)
    file = script.resolve().relative_to(project.root.resolve()).as_posix()
    return Controller(script, project, file, source)


def forbid_compiled(path: Path | str, purpose: str) -> None:
    """Raise InputError for a controller in C or C++, no run of which can be repeated exactly."""
    if is_c(Path(path).name):
        raise InputError(
            f"is C or C++, whose node runs live alone, and {purpose} repeats runs exactly; "
            f"`tracerisk run {path} --live -- COMMAND` shows one run",
            Location(str(path)),
        )


def _forbid_made(source: bytes, shown: str) -> None:
    """Raise InputError for a script that a build wrote to start another one."""
    if b"catkin" not in source and b"EASY-INSTALL" not in source:
        return  # as nearly every script is, for which no expression need be compiled
    relay, entry = (re.search(text, source, re.MULTILINE) for text in (_RELAY, _ENTRY))
    if relay is not None:
        raise InputError(
            "is a script that catkin wrote to start another one; name that one: "
            f"{relay[1].decode(errors='replace')}",
            Location(shown),
        )
    if entry is not None:
        package, name = (group.decode(errors="replace") for group in entry.groups())
        raise InputError(
            f"is a script that setuptools wrote for the entry point '{name}' of '{package}'; name "
            f"the module that entry_points in its setup.py gives '{name}'",
            Location(shown),
        )


def string_literals(controller: Controller) -> tuple[str, ...]:
    """Return the strings in a controller's source, in their order.

    Names that are made by counting (`[f"joint_{i}" for i in range(1, 7)]`) come last.
    """
    # Where blocks alone are asked for, no source is parsed.
    from tracerisk.instrument.source.literals.named_literals import counted_names
    from tracerisk.instrument.source.python_source import parse_source, texts_in

    if not controller.is_python:
        from tracerisk.instrument.source.c_tokens import strings_in

        return tuple(strings_in(controller.source))
    tree = controller.tree
    if tree is None:
        # It knows how to say what is wrong, and of Python 2.
        tree = parse_source(controller.source, str(controller.path)).tree
    return (*texts_in(tree), *(name for node in ast.walk(tree) for name in counted_names(node)))


def function_of(controller: Controller, place: Location | None) -> str:
    """Return the qualified name of the function around a place; empty where there is none."""
    if place is None or place.line is None or not place.file.endswith(".py"):
        return ""
    path = controller.path_of(place.file)
    if place.file != controller.file and not path.is_file():
        return ""
    return _function_at(controller.source_of(place.file), str(path), place.line)


@lru_cache(maxsize=4096)
def _function_at(source: bytes, file: str, line: int) -> str:
    try:
        return function_at(parse_python(source, file).tree, line)
    except TraceRiskError:
        return ""
