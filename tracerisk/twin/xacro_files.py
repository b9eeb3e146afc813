"""Expand xacro files without ROS; packages are those of the workspace."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from tracerisk.errors import Location, RobotError

_LIMIT_S = 25.0
_LONGEST_REASON = 200


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
    file = shown if shown is not None else str(path)
    asked = {
        "path": str(path.resolve()),
        "packages": {name: str(folder) for name, folder in packages.items()},
        "arguments": dict(arguments or {}),
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
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        reason = lines[-1].strip() if lines else f"its process ended with {done.returncode}"
        raise RobotError(f"xacro cannot expand it: {reason[:_LONGEST_REASON]}", Location(file))
    return done.stdout
