"""Temporary folders that are gone with their process, however that ends.

A process that is killed leaves its folders. Each holds a file that its owner has locked, so the
next process knows which have no owner any more, and removes them.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

_PREFIX = "tracerisk-"
_OWNER = ".owner"
_TRIES, _BETWEEN_S = 20, 0.1  # to remove a folder

_LOCK = threading.Lock()
_OWNED: dict[Path, int] = {}
"""The folders of this process, each with the descriptor of its locked file."""


if sys.platform != "win32":
    import fcntl

    # A process that is forked owns nothing of its parent's.
    os.register_at_fork(after_in_child=_OWNED.clear)


def new_scratch(kind: str = "") -> Path:
    """Return a new folder for temporary files, which this process removes at its end at the latest.

    With the first one, those of processes that were killed are removed.
    """
    with _LOCK:
        if not _OWNED:
            remove_ownerless(Path(tempfile.gettempdir()))
            atexit.unregister(_remove_all)
            atexit.register(_remove_all)
        folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{kind}")).resolve()
        # The file has its name only when it is locked: nobody takes the folder for ownerless.
        descriptor, unnamed = tempfile.mkstemp(dir=folder)
        _lock(descriptor)
        Path(unnamed).rename(folder / _OWNER)
        _OWNED[folder] = descriptor
    return folder


def remove_scratch(folder: Path) -> None:
    """Remove a folder of `new_scratch`, also where a process may still write into it."""
    for _ in range(_TRIES):
        remove_tree(folder)
        if not folder.exists():
            break
        time.sleep(_BETWEEN_S)
    descriptor = _OWNED.pop(folder, None)
    if descriptor is not None:
        os.close(descriptor)


@contextlib.contextmanager
def scratch(kind: str = "") -> Iterator[Path]:
    """Yield a folder for temporary files, which is gone afterwards."""
    folder = new_scratch(kind)
    try:
        yield folder
    finally:
        remove_scratch(folder)


def remove_tree(folder: Path) -> None:
    """Remove a folder, however deep a controller has made it and whatever it forbids."""
    try:
        shutil.rmtree(folder)
    except (OSError, RecursionError):
        for command in (["chmod", "-R", "u+rwx"], ["rm", "-rf"]):
            with contextlib.suppress(OSError):
                subprocess.run(
                    [*command, "--", str(folder)], stderr=subprocess.DEVNULL, check=False
                )


def remove_ownerless(top: Path) -> None:
    """Remove the folders below `top` whose owner has ended without removing them."""
    for folder in top.glob(f"{_PREFIX}*"):
        owner = folder / _OWNER
        try:
            descriptor = os.open(owner, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
        except OSError:
            continue
        try:
            is_ours = os.fstat(descriptor).st_uid == folder.lstat().st_uid == os.geteuid()
            if is_ours and not folder.is_symlink() and _lock(descriptor):
                remove_tree(folder)
        except OSError:
            continue  # another removes it too
        finally:
            os.close(descriptor)


def _lock(descriptor: int) -> bool:
    """Lock a file for as long as it is open; return whether nobody else has."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove_all() -> None:
    for folder in list(_OWNED):
        remove_scratch(folder)
