"""End whatever a controller started and left running."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

RUN_MARK = "TRACERISK_RUN"
"""The environment variable by which the processes of one run are known."""

_PROCESSES = Path("/proc")
_ROUNDS = 20


def end_left_running(group: int, mark: str) -> None:
    """Kill the process group of a run, and what left the group: the processes with its mark.

    A process may start another while it is looked for, so it is looked for until none is found.
    """
    _kill_group(group)
    for _ in range(_ROUNDS):
        found = _marked(mark)
        if not found:
            return
        for process in found:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(process, signal.SIGKILL)


def _kill_group(group: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, signal.SIGKILL)


def _marked(mark: str) -> list[int]:
    wanted = f"{RUN_MARK}={mark}".encode()
    found = []
    for folder in _PROCESSES.glob("[0-9]*"):
        # Those of other users, and those that have just ended, cannot be read.
        with contextlib.suppress(OSError):
            if wanted in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
    return sorted(found)
