"""Expand xacro files without ROS; packages are those of the workspace."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.common.limits import DEFAULT_LIMITS, Limits
from tracerisk.common.sandbox.limited_process import last_words, run_limited
from tracerisk.common.sandbox.process import regular_within
from tracerisk.common.sandbox.ros_prefix import readable_folders
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import controller_root
from tracerisk.errors import Location, RobotError
from tracerisk.twin.urdf.xacro_child import REFUSED

_LONGEST_REASON = 200
_ABSENT_ARGUMENT = re.compile(
    r"Undefined substitution argument (\w+)|^when evaluating expression 'xacro\.arg\(\W(\w+)\W\)'",
    re.MULTILINE,
)
_ABSENT_PACKAGE = re.compile(r"Package not found: ([\w.-]+)")


@dataclass(frozen=True, slots=True)
class Expanded:
    """What a xacro file expands to."""

    text: bytes
    """The XML."""
    files: tuple[Path, ...]
    """The files that were read for it."""
    packages: tuple[str, ...] = ()
    """The packages that were absent."""
    arguments: tuple[str, ...] = ()
    """The arguments that nothing gave, taken for empty; constants of absent files, taken for 0."""
    includes: tuple[str, ...] = ()
    """The files of absent packages that it includes, the package's name first."""
    is_old: bool = False
    """Whether it has forms that xacro no longer takes: tags without prefix, `__name`."""


class LackingError(RobotError):
    """A xacro file needs a package or an argument that is absent."""


def expand_xacro(
    path: Path,
    packages: Mapping[str, Path],
    *,
    arguments: Mapping[str, str] | None = None,
    shown: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
) -> bytes:
    """Return the XML that a xacro file expands to, with `$(find ...)` among the packages.

    It is expanded in a process with limits of time and memory.
    Raises RobotError with xacro's reason when it cannot be expanded, LimitError where that takes
    too long or too much memory.
    """
    return expanded_xacro(path, packages, arguments=arguments, shown=shown, limits=limits).text


def expanded_xacro(
    path: Path,
    packages: Mapping[str, Path],
    *,
    arguments: Mapping[str, str] | None = None,
    within: Sequence[Path] | None = None,
    shown: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
    may_lack: bool = False,
) -> Expanded:
    """Return what a xacro file expands to; `within` are the folders whose files it may read.

    `may_lack`: files of absent packages are left out, calls of their macros stay as elements
    `ABSENT_MACRO`, constants that they may give are 0, and arguments that nothing gives are empty.
    Raises LackingError where something of the kind is absent and must not be; RobotError and
    LimitError as `expand_xacro` does, RobotError at a file outside the folders.
    """
    file = shown if shown is not None else str(path)
    asked = {
        "path": str(path.resolve()),
        "packages": {name: str(folder) for name, folder in packages.items()},
        "arguments": dict(arguments or {}),
        "within": None if within is None else [str(folder.resolve()) for folder in within],
        "lacking": may_lack,
    }
    folders = readable_folders(packages.values())
    around = [path.parent, controller_root(path), *folders, *(within or ())]
    done = run_limited(
        "tracerisk.twin.urdf.xacro_child",
        request=json.dumps(asked).encode(),
        limits=limits,
        doing="expanding the xacro file",
        place=Location(file),
        reads=around,
    )
    if done.returncode == REFUSED:
        raise _refusal(json.loads(done.stdout), file, path)
    if done.returncode != 0:
        reason = last_words(done)
        said = done.stderr.decode(errors="replace")
        absent = _ABSENT_PACKAGE.search(said)
        if absent is not None:
            raise LackingError(
                f"xacro cannot expand it: package '{absent[1]}' is neither in the workspace nor "
                "installed; put it there, or source the ROS that has it",
                Location(file),
            )
        argument = _ABSENT_ARGUMENT.search(said)
        if argument is not None:
            name = argument[1] or argument[2]
            raise LackingError(
                f"xacro cannot expand it: nothing gives its argument {name}; give it in the launch "
                "file that loads it",
                Location(file),
            )
        raise RobotError(f"xacro cannot expand it: {reason[:_LONGEST_REASON]}", Location(file))
    try:
        answer = json.loads(done.stdout)
        text, files = answer["text"].encode(), [str(item) for item in answer["files"]]
        lacked = {
            key: tuple(map(str, answer[key])) for key in ("packages", "arguments", "includes")
        }
        is_old = bool(answer["is_old"])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise RobotError("xacro gave no document; its macros may print", Location(file)) from error
    return Expanded(text, regular_within(files, around), **lacked, is_old=is_old)


def _refusal(answer: Mapping[str, Any], shown: str, path: Path) -> RobotError:
    """Return the error at the line of the file that names what lies outside the folders."""
    asked, top = answer["asked"], answer["within"][0]
    line = None
    where = shown
    if answer["by"] is not None:
        by = Path(answer["by"])
        where = shown if by == path.resolve() else str(by)
        name = asked.rpartition("/")[2].encode()
        lines = file_bytes(by).splitlines()
        line = next((number for number, chunk in enumerate(lines, 1) if name in chunk), None)
    return RobotError(
        f"'{asked}' lies outside {top} and the packages of the workspace, and only files in them "
        "are read; put the file there, or take this line out",
        Location(where, line),
    )
