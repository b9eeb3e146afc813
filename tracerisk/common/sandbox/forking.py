"""Fork a process in the middle of its work, so that parent and child share no file.

`os.fork` is no use for it: Python then ends its threads for itself, seeds its random numbers anew
and calls what libraries have registered, and the child would go on differently from its parent.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import shutil
import stat
import sys
from collections.abc import Mapping
from pathlib import Path

_HIGHEST = 4096  # descriptors that are looked at
_DELETED = " (deleted)"
_TASKS = Path("/proc/self/task")
_OPENED = "/proc/self/fd/{}"
_KEPT_FLAGS = os.O_ACCMODE | os.O_APPEND | os.O_NONBLOCK


class NotForkableError(Exception):
    """Why the process cannot be forked as it is now, in words."""


def open_descriptors() -> frozenset[int]:
    """Return the descriptors that are open."""
    return frozenset(index for index in range(_HIGHEST) if _status(index) is not None)


def fork_apart(moved: Mapping[str, str], known: frozenset[int]) -> int:
    """Fork, and return the child's number; 0 in the child, which prints nothing any more.

    `moved` maps folders to the copies that are made of them: what the child has open below one,
    it has open in the copy. Each child reads other files from where the parent was, by itself.
    `known` are descriptors of pipes and the like that parent and child may share.
    Raises NotForkableError where there are threads, the two would share more, or a folder cannot be
    copied.
    """
    _check_alone()
    try:
        for folder, copy in moved.items():
            shutil.copytree(folder, copy, symlinks=True, dirs_exist_ok=True)
    except OSError as error:
        raise NotForkableError(f"the files it wrote cannot be copied: {error}") from error
    reopened: dict[int, int] = {}
    try:
        for descriptor in sorted(open_descriptors() - {0, 1, 2}):
            number = _reopened(descriptor, moved, known)
            if number is not None:
                reopened[descriptor] = number
        silent = reopened[1] = os.open(os.devnull, os.O_RDWR)
        child = _fork()
        if child == 0:
            os.dup2(silent, 2)
            for descriptor, fresh in reopened.items():
                os.dup2(fresh, descriptor, inheritable=os.get_inheritable(descriptor))
        return child
    finally:
        for fresh in reopened.values():
            os.close(fresh)


def _check_alone() -> None:
    """Raise NotForkableError where the process has a thread that does not end before a fork."""
    if sys.platform != "linux":
        raise NotForkableError("processes can be forked on Linux only")
    if _threads() > 1:
        # Those of libraries for linear algebra end before it, and start again when needed.
        child = _fork()
        if child == 0:
            os._exit(0)
        os.waitpid(child, 0)
    if _threads() > 1:
        raise NotForkableError("a library of the controller runs its own threads")


def _threads() -> int:
    # A contained process cannot list them, but count.
    return _TASKS.stat().st_nlink - 2


def _fork() -> int:
    # Keeps the interpreter's lock, which the child has as its parent had it.
    fork = ctypes.PyDLL(None, use_errno=True).fork
    fork.argtypes = ()
    child = int(fork())
    if child < 0:
        raise NotForkableError(
            f"the system cannot fork a process: {os.strerror(ctypes.get_errno())}"
        )
    return child


def _reopened(descriptor: int, moved: Mapping[str, str], known: frozenset[int]) -> int | None:
    """Open once more what a descriptor is of, for the child; None where both may share it."""
    status = _status(descriptor)
    if status is None or stat.S_ISDIR(status.st_mode) or stat.S_ISCHR(status.st_mode):
        return None
    flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
    if flags & os.O_PATH:
        return None  # held, not read: there is no position in it to share
    if not stat.S_ISREG(status.st_mode):
        if descriptor in known:
            return None
        kind = "socket" if stat.S_ISSOCK(status.st_mode) else "pipe or event queue"
        raise NotForkableError(
            f"the controller has an open {kind}, which two processes cannot share"
        )
    path = str(Path(_OPENED.format(descriptor)).readlink())
    copy = next(
        (to + path[len(top) :] for top, to in moved.items() if path.startswith(f"{top}/")), None
    )
    if copy is None and flags & os.O_ACCMODE == os.O_RDONLY:
        copy = _OPENED.format(descriptor)
    if copy is None or path.endswith(_DELETED):
        raise NotForkableError(f"the controller has {path} open for writing")
    try:
        fresh = os.open(copy, flags & _KEPT_FLAGS | os.O_CLOEXEC)
    except OSError as error:
        raise NotForkableError(f"{path} cannot be opened once more: {error.strerror}") from error
    os.lseek(fresh, os.lseek(descriptor, 0, os.SEEK_CUR), os.SEEK_SET)
    return fresh


def _status(descriptor: int) -> os.stat_result | None:
    try:
        return os.fstat(descriptor)
    except OSError as error:
        if error.errno != errno.EBADF:
            raise
        return None
