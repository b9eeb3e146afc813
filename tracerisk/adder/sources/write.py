"""Write files so that a kill at any moment leaves each of them old or new, and whole."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.errors import InputError, Location

_LONGEST_WRITE_S = 3600.0
_LEFTOVER = re.compile(r"\.(?P<of>.+)\.(?P<process>\d+)-\d+\.tmp")


@dataclass(frozen=True, slots=True)
class FileWrite:
    """New content for a file."""

    path: Path
    """The path of the file."""
    data: bytes
    """The content to write."""
    expected: bytes | None = None
    """The content that it was made from, which the file must still hold; `None` for no check."""


def write_all(writes: Iterable[FileWrite]) -> None:
    """Make the writes in their order; the lock comes first, for it says what follows.

    Raises:
        InputError: if a file cannot be written, or no longer holds what it was read as.
            What can be known beforehand is reported before the first write.
    """
    planned = tuple(writes)
    for write in planned:
        _check_writable(write.path)
        _check_expected(write)
    for write in planned:
        atomic_write(write.path, write.data, write.expected)


def _check_writable(path: Path) -> None:
    target = path.resolve()
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError("is read-only; make it writable to have it annotated", Location(str(path)))


def _check_expected(write: FileWrite) -> None:
    if write.expected is not None and file_bytes(write.path, MOST_WRITTEN) != write.expected:
        raise InputError(
            "was changed by someone else meanwhile; run the same command again",
            Location(str(write.path)),
        )


def atomic_write(path: Path, data: bytes, expected: bytes | None = None) -> None:
    """Replace the content of the file at `path` as one step, mode bits and links kept.

    The new content is on the disk before it takes the name; a symbolic link stays and the
    file it leads to is replaced. A file with further hard links is written in place, because
    replacing it would break the links; only this case is not atomic.
    What the file holds is compared with `expected` last of all.

    Raises:
        InputError: if the file or its folder cannot be written, or holds something else than
            `expected`.
    """
    target = path.resolve()
    try:
        _remove_leftovers(target)
        with _written_beside(target, data) as (temporary, stream):
            _check_expected(FileWrite(path, data, expected))
            if _links(target) > 1:
                _overwrite(target, data)
            else:
                temporary.take_name(stream)
        _sync_folder(target.parent)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}", Location(str(path))
        ) from error


def _links(target: Path) -> int:
    try:
        return target.stat().st_nlink
    except FileNotFoundError:
        return 0


def _overwrite(target: Path, data: bytes) -> None:
    with target.open("r+b") as stream:
        stream.write(data)
        stream.truncate()
        stream.flush()
        os.fsync(stream.fileno())


class _Temporary:
    """A new file in the folder of its target, without a name where the system can do that.

    Then a kill leaves nothing behind; it gets a name only just before it replaces the target.
    """

    def __init__(self, target: Path) -> None:
        self._target = target
        self._path: Path | None = None
        # Linux alone has files without a name, and some file systems, those of networks say, lack
        # them there too.
        unnamed = None
        if sys.platform == "linux":
            with contextlib.suppress(OSError):
                unnamed = os.open(target.parent, os.O_WRONLY | os.O_TMPFILE, 0o666)
        self.descriptor = self._create() if unnamed is None else unnamed

    def _names(self) -> Iterator[Path]:
        for number in itertools.count():
            yield self._target.with_name(f".{self._target.name}.{os.getpid()}-{number}.tmp")

    def _create(self) -> int:
        for path in self._names():
            with contextlib.suppress(FileExistsError):
                descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
                self._path = path
                return descriptor
        raise AssertionError("there is always a further name")

    def take_name(self, stream: BinaryIO) -> None:
        """Put the file, which is open as `stream`, in the place of its target; close it."""
        if self._path is None:
            self._path = self._link()
        stream.close()  # Windows renames no file that is open
        self._path.replace(self._target)
        self._path = None

    def _link(self) -> Path:
        folder = os.open(self._target.parent, os.O_RDONLY)
        try:
            for path in self._names():
                with contextlib.suppress(FileExistsError):
                    os.link(f"/proc/self/fd/{self.descriptor}", path.name, dst_dir_fd=folder)
                    return path
        finally:
            os.close(folder)
        raise AssertionError("there is always a further name")

    def remove(self) -> None:
        """Delete the file unless it has replaced its target."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)


@contextlib.contextmanager
def _written_beside(target: Path, data: bytes) -> Iterator[tuple[_Temporary, BinaryIO]]:
    """Yield a new file that holds `data`, on the disk already, with the mode of `target`."""
    temporary = _Temporary(target)
    try:
        with os.fdopen(temporary.descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            if sys.platform != "win32":  # its one mode bit is for files that we refuse to write
                with contextlib.suppress(FileNotFoundError):
                    os.fchmod(stream.fileno(), stat.S_IMODE(target.stat().st_mode))
            os.fsync(stream.fileno())
            yield temporary, stream
    finally:
        temporary.remove()


def _remove_leftovers(target: Path) -> None:
    """Remove what killed writers left beside the files that they were to write, this or others."""
    with os.scandir(target.parent) as entries:
        pairs = [
            (Path(entry.path), match)
            for entry in entries
            if (match := _LEFTOVER.fullmatch(entry.name))
        ]
    for path, match in pairs:
        is_ours = match["of"] == target.name or path.with_name(match["of"]).is_file()
        if is_ours and not _is_in_use(path, int(match["process"])):
            path.unlink(missing_ok=True)


def _is_in_use(path: Path, process: int) -> bool:
    """Return whether the process that made a temporary file may still write it."""
    if sys.platform == "win32":
        # There is no asking: `os.kill` would end the process.
        return time.time() - path.stat().st_mtime < _LONGEST_WRITE_S
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OverflowError, PermissionError):
        return True
    return True


def _sync_folder(folder: Path) -> None:
    if sys.platform == "win32":
        return  # it opens no folder, and keeps names by itself
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
