"""Lock a folder, so that one process at a time writes what several share."""

from __future__ import annotations

import contextlib
import os
import sys
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

    A process that dies gives it free, and the folder itself gets no file.
    Raises LimitError where another process keeps it for more than `LONGEST_WAIT_S`.
    """
    descriptor = _opened(folder)
    try:
        _wait(descriptor, folder)
        yield
    finally:
        os.close(descriptor)


def _wait(descriptor: int, folder: Path) -> None:
    began = monotonic()
    while not _is_locked(descriptor):
        if monotonic() - began > LONGEST_WAIT_S:
            raise LimitError(
                f"another process has kept this folder locked for {LONGEST_WAIT_S:g} s, and "
                f"nothing was written; end that process{_WHICH}, and run the same command again",
                Location(str(folder)),
            )
        sleep(_POLL_S)


if sys.platform == "win32":
    import hashlib
    import msvcrt
    import tempfile

    _WHICH = " (the Task Manager lists it as python or tracerisk)"

    def _opened(folder: Path) -> int:
        """Open a file that stands for a folder, as none can be opened: one of this user's."""
        name = os.path.normcase(folder.resolve()).encode("utf-8", "surrogatepass")
        digest = hashlib.sha256(name).hexdigest()[:16]
        stand_in = Path(tempfile.gettempdir(), f"tracerisk-{digest}.lock")
        return os.open(stand_in, os.O_RDWR | os.O_CREAT)

    def _is_locked(descriptor: int) -> bool:
        """Lock a file for as long as it is open; return whether nobody else has."""
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            return False
        return True

else:
    import fcntl

    _WHICH = " (`fuser` names it)"

    def _opened(folder: Path) -> int:
        return os.open(folder, os.O_RDONLY)

    def _is_locked(descriptor: int) -> bool:
        """Lock a folder for as long as it is open; return whether nobody else has."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
