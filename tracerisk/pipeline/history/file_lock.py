"""Lock a folder, so that one process at a time writes what several share."""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

from tracerisk.errors import LimitError, Location

LONGEST_WAIT_S = 60.0
"""How long another process may write before this one gives up [s of wall time]."""
_POLL_S = 0.02


@contextlib.contextmanager
def one_writer(folder: Path) -> Iterator[None]:
    """Wait until no other process of tracerisk writes in the folder, and keep them out.

    The folder itself is locked, so no file of ours stays; a process that dies gives it free.
    Raises LimitError where another process keeps it for more than `LONGEST_WAIT_S`.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        _wait(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def _wait(descriptor: int, folder: Path) -> None:
    began = monotonic()
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if monotonic() - began > LONGEST_WAIT_S:
                raise LimitError(
                    f"another process has kept this folder locked for {LONGEST_WAIT_S:g} s, and "
                    "nothing was written; end that process (`fuser` names it), and run "
                    "the same command again",
                    Location(str(folder)),
                ) from None
            sleep(_POLL_S)
        else:
            return
