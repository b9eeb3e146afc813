"""Expand xacro files without ROS; packages are those of the workspace."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.errors import Location, RobotError
from tracerisk.twin.xacro_child import REFUSED

_LIMIT_S = 25.0
_LONGEST_REASON = 200


@dataclass(frozen=True, slots=True)
class Expanded:
    """The XML that a xacro file expands to, and the files that were read for it."""

    text: bytes
    files: tuple[Path, ...]


def expand_xacro(
    path: Path,
    packages: Mapping[str, Path],
    *,
    arguments: Mapping[str, str] | None = None,
    shown: str | None = None,
) -> bytes:
    """Return the XML that a xacro file expands to, with `$(find ...)` among the packages.

    It is expanded in a process with limits of time and memory.
    Raises RobotError with xacro's reason when it cannot be expanded.
    """
    return expanded_xacro(path, packages, arguments=arguments, shown=shown).text


def expanded_xacro(
    path: Path,
    packages: Mapping[str, Path],
    *,
    arguments: Mapping[str, str] | None = None,
    within: Sequence[Path] | None = None,
    shown: str | None = None,
) -> Expanded:
    """Return what a xacro file expands to; `within` are the folders whose files it may read.

    Raises RobotError as `expand_xacro` does, and at a file outside the folders.
    """
    file = shown if shown is not None else str(path)
    asked = {
        "path": str(path.resolve()),
        "packages": {name: str(folder) for name, folder in packages.items()},
        "arguments": dict(arguments or {}),
        "within": None if within is None else [str(folder.resolve()) for folder in within],
    }
    try:
        done = subprocess.run(
            [sys.executable, "-m", "tracerisk.twin.xacro_child"],
            input=json.dumps(asked).encode(),
            capture_output=True,
            timeout=_LIMIT_S,
            check=False,
            # What the host has sourced must not decide which robot is found.
            env={k: v for k, v in os.environ.items() if not k.startswith(("ROS_", "AMENT_"))},
        )
    except subprocess.TimeoutExpired as error:
        raise RobotError(
            f"xacro does not come to an end within {_LIMIT_S:g} s", Location(file)
        ) from error
    if done.returncode == REFUSED:
        raise _refusal(json.loads(done.stdout), file, path)
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        reason = lines[-1].strip() if lines else f"its process ended with {done.returncode}"
        raise RobotError(f"xacro cannot expand it: {reason[:_LONGEST_REASON]}", Location(file))
    answer = json.loads(done.stdout)
    return Expanded(answer["text"].encode(), tuple(Path(each) for each in answer["files"]))


def _refusal(told: Mapping[str, Any], shown: str, path: Path) -> RobotError:
    """Return the error at the line of the file that names what lies outside the folders."""
    asked, top = told["asked"], told["within"][0]
    line = None
    where = shown
    if told["by"] is not None:
        by = Path(told["by"])
        where = shown if by == path.resolve() else str(by)
        name = asked.rpartition("/")[2].encode()
        lines = by.read_bytes().splitlines()
        line = next((number for number, each in enumerate(lines, 1) if name in each), None)
    return RobotError(
        f"'{asked}' lies outside {top} and the packages of the workspace, and only files in them "
        "are read; put the file there, or take this line out",
        Location(where, line),
    )
