"""Write files so that a kill at any moment leaves each of them old or new, and whole."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import stat
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.errors import InputError, Location

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
    if write.expected is not None and write.path.read_bytes() != write.expected:
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
        with _written_beside(target, data) as temporary:
            _check_expected(FileWrite(path, data, expected))
            if _links(target) > 1:
                _overwrite(target, data)
            else:
                temporary.take_name()
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
        try:
            self.descriptor = os.open(target.parent, os.O_WRONLY | os.O_TMPFILE, 0o666)
        except OSError:
            # Some file systems, those of networks say, have no files without a name.
            self.descriptor = self._create()

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

    def take_name(self) -> None:
        """Put the file in the place of its target."""
        if self._path is None:
            self._path = self._link()
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
def _written_beside(target: Path, data: bytes) -> Iterator[_Temporary]:
    """Yield a new file that holds `data`, on the disk already, with the mode of `target`."""
    temporary = _Temporary(target)
    try:
        with os.fdopen(temporary.descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            with contextlib.suppress(FileNotFoundError):
                os.fchmod(stream.fileno(), stat.S_IMODE(target.stat().st_mode))
            os.fsync(stream.fileno())
            yield temporary
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
        if is_ours and not _is_running(int(match["process"])):
            path.unlink(missing_ok=True)


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OverflowError, PermissionError):
        return True
    return True


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
