"""Arguments of launch files in the commands of readmes: `ros2 launch cell arm.launch.py x:=1`.

Whoever follows the readme starts the file so; its defaults may be of another robot.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from pathlib import Path

from tracerisk.common.text.bounded import regular_file
from tracerisk.pipeline.launch.find import LaunchFile
from tracerisk.pipeline.workspace.controller import from_root
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace, searched

_MOST_FOLDERS = 1000
_MOST_FILES = 200
_MOST_BYTES = 256 * 1024
_README = re.compile(r"readme(\..*)?|.*\.(md|rst)", re.IGNORECASE)
_LAUNCH = re.compile(r"(?:roslaunch|ros2\s+launch)\s+(?P<rest>.*)")
_ARGUMENT = re.compile(r"(?P<name>[A-Za-z_]\w*):=(?P<value>.*)", re.DOTALL)
_PLACEHOLDER = re.compile(r"[<>{}\[\]$|`*]|\.\.\.|^(x+|y+)(\.(x+|y+))*$|^$", re.IGNORECASE)
_ENDS = frozenset({"&&", "||", ";", "|", "&", "#"})


@dataclass(frozen=True, slots=True)
class _Command:
    """A command that starts a launch file."""

    package: str
    """The package that it names; empty where it names the file by its path."""
    file: str
    """The file's name."""
    arguments: tuple[tuple[str, str], ...]
    """Those that it gives, but for placeholders such as `<ip>`."""
    place: str
    """Where it stands: `README.md:12`, from the controller's root."""


class ReadmeArguments:
    """The arguments that the readmes of a project give launch files."""

    def __init__(self, project: Project, workspace: Workspace) -> None:
        self._project = project
        self._root = project.root.resolve()
        self._packages: Mapping[str, Path] = workspace.findable

    def given(self, file: LaunchFile) -> LaunchFile:
        """Return a launch file with the arguments of the first command that gives it any."""
        for command in self._commands:
            folder = self._packages.get(command.package)
            is_of_package = folder is None or file.path.is_relative_to(folder.resolve())
            if command.file == file.path.name and command.arguments and is_of_package:
                return replace(file, arguments=command.arguments, said_in=command.place)
        return file

    @cached_property
    def _commands(self) -> tuple[_Command, ...]:
        """The commands, those of the readmes nearest to the root first."""
        paths = [
            Path(folder, name)
            for folder, names in islice(searched(self._project.top), _MOST_FOLDERS)
            for name in names
            if _README.fullmatch(name)
        ][:_MOST_FILES]
        paths.sort(key=lambda path: (not self._root.is_relative_to(path.parent), path))
        return tuple(command for path in paths for command in self._in_file(path))

    def _in_file(self, path: Path) -> Iterator[_Command]:
        try:
            with regular_file(path) as stream:
                lines = stream.read(_MOST_BYTES).decode("utf-8", errors="replace").splitlines()
        except OSError:
            return
        for number, line in enumerate(lines):
            match = _LAUNCH.search(line)
            if match is None:
                continue
            text = match["rest"]
            for more in lines[number + 1 :]:
                if not text.rstrip().endswith("\\"):
                    break
                text = f"{text.rstrip()[:-1]} {more.strip()}"
            # A tick of Markdown ends a command within a sentence.
            command = _command(
                text.partition("`")[0], f"{from_root(self._root, path)}:{number + 1}"
            )
            if command is not None:
                yield command


def _command(text: str, place: str) -> _Command | None:
    try:
        words = shlex.split(text, comments=True)
    except ValueError:
        words = text.split()
    words = words[: next((at for at, word in enumerate(words) if word in _ENDS), len(words))]
    named = [word for word in words if ":=" not in word and not word.startswith("-")]
    if not named:
        return None
    package, file = (named[0], named[1]) if len(named) > 1 else ("", named[0])
    matches = [match for word in words if (match := _ARGUMENT.fullmatch(word)) is not None]
    given = [(match["name"], match["value"].rstrip(",.")) for match in matches]
    kept = tuple((name, value) for name, value in given if not _PLACEHOLDER.search(value))
    return _Command(package, Path(file).name, kept, place)
