"""Which files launch files take a robot from: what xacro is called with, and what they read."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.placeholders import ABSENT_FOLDER

_ENDINGS = (".xacro", ".urdf", ".srdf")
_GIVES = ":="


@dataclass(frozen=True, slots=True)
class RobotSource:
    """A robot description file with the arguments of xacro, or why it is not known."""

    path: str
    """The absolute path; empty where it is not known."""
    arguments: tuple[tuple[str, str], ...] = ()
    """The name and value of each xacro argument."""
    problem: str = ""
    """Why the file is not known; empty where it is."""


def source_of_command(command: str, folder: Path) -> RobotSource | None:
    """Return the file that a command line of xacro or `cat` names, `None` where it names none.

    A path that is not absolute starts from `folder`.
    """
    try:
        words = shlex.split(command)
    except ValueError:
        words = command.split()
    named = [word for word in words[1:] if word.endswith(_ENDINGS) and _GIVES not in word]
    if not named:
        return None
    pairs = (word.partition(_GIVES) for word in words if _GIVES in word)
    given = tuple((name, value) for name, _, value in pairs)
    return _known(RobotSource(str(folder / named[0]), given))


def _known(source: RobotSource) -> RobotSource:
    path = Path(source.path)
    if not path.is_relative_to(ABSENT_FOLDER) or path == ABSENT_FOLDER:
        return source
    package = path.relative_to(ABSENT_FOLDER).parts[0]
    return RobotSource("", problem=f"package '{package}' is not here")


def source_of_problem(command: str, problem: str) -> RobotSource | None:
    """Return why the file that a command line names is not known, `None` where it names none."""
    return RobotSource("", problem=problem) if any(map(command.__contains__, _ENDINGS)) else None


def source_of_file(path: str | Path, arguments: Mapping[str, Any] | None = None) -> RobotSource:
    """Return what a file and the arguments of xacro come to; only those that are known as texts."""
    given = tuple(
        (str(name), _text(value))
        for name, value in (arguments or {}).items()
        if isinstance(value, str | int | float | Path)
    )
    return _known(RobotSource(str(path), given))


def _text(value: str | float | Path) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def is_robot_file(path: str | Path) -> bool:
    """Return whether a file may describe a robot, by its name."""
    return str(path).endswith(_ENDINGS)


def robots_read(sources: Iterable[RobotSource]) -> tuple[RobotSource, ...]:
    """Return the sources each once; those that xacro is given something for go before others."""
    robot_sources: dict[str, RobotSource] = {}
    for source in sources:
        known = robot_sources.get(source.path or source.problem)
        if known is None or (source.arguments and not known.arguments):
            robot_sources[source.path or source.problem] = source
    return tuple(robot_sources.values())
