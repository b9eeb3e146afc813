"""A machine under load: whatever a command starts gets one twentieth of the time."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

from tests.conftest import Outcome

RUNS_S, STOPPED_S = 0.010, 0.190


def _parents() -> dict[int, int]:
    """Return the parent of each process of the system."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            found[int(folder.name)] = int(
                (folder / "stat").read_bytes().rpartition(b")")[2].split()[1]
            )
    return found


def descendants(process: int) -> list[int]:
    """Return the processes that a process has started, and theirs."""
    parents = _parents()
    found: list[int] = []
    above = {process}
    while above:
        above = {child for child, parent in parents.items() if parent in above}
        found += sorted(above)
    return found


def _signal(processes: list[int], number: int) -> None:
    for each in processes:
        with contextlib.suppress(ProcessLookupError):
            os.kill(each, number)


def run_under_load(folder: Path, *arguments: str) -> tuple[Outcome, int]:
    """Run the command, its child processes stopped for nineteen twentieths of the time.

    Return the outcome, and how often a process was stopped.
    """
    with subprocess.Popen(
        [sys.executable, "-m", "tracerisk", *arguments],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as command:
        is_over = threading.Event()
        stops = 0

        def load() -> None:
            nonlocal stops
            while not is_over.wait(RUNS_S):
                stopped = descendants(command.pid)
                _signal(stopped, signal.SIGSTOP)
                stops += len(stopped)
                is_over.wait(STOPPED_S)
                _signal(stopped, signal.SIGCONT)

        loading = threading.Thread(target=load)
        loading.start()
        try:
            out, err = command.communicate()
        finally:
            is_over.set()
            loading.join()
    return Outcome(command.returncode, out.decode(), err.decode()), stops
