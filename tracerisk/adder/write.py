"""Write files so that a kill at any moment leaves each of them old or new, and whole."""

from __future__ import annotations

import contextlib
import os
import re
import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from tracerisk.errors import InputError, Location


@dataclass(frozen=True, slots=True)
class FileWrite:
    """New content for a file; `expected` is what it was made from, where that matters."""

    path: Path
    data: bytes
    expected: bytes | None = None


def write_all(writes: Iterable[FileWrite]) -> None:
    """Make the writes in their order; the lock comes first, for it says what follows.

    Raises:
        InputError: if a file cannot be written, or no longer holds what it was read as.
            What can be told beforehand is told before the first write.
    """
    planned = tuple(writes)
    for write in planned:
        _check_writable(write.path)
        _check_expected(write)
    for write in planned:
        _check_expected(write)
        atomic_write(write.path, write.data)


def _check_writable(path: Path) -> None:
    target = path.resolve()
    if target.exists() and not os.access(target, os.W_OK):
        raise InputError("is read-only; make it writable to have it annotated", Location(str(path)))


def _check_expected(write: FileWrite) -> None:
    if write.expected is not None and write.path.read_bytes() != write.expected:
        raise InputError(
            "was changed by someone else meanwhile; run tracerisk again", Location(str(write.path))
        )


def atomic_write(path: Path, data: bytes) -> None:
    """Replace the content of the file at `path` as one step, mode bits and links kept.

    The new content is on the disk before it takes the name; a symbolic link stays and the
    file it leads to is replaced.

    Raises:
        InputError: if the file or its folder cannot be written.
    """
    target = path.resolve()
    try:
        temporary = _write_beside(target, data)
        try:
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        _remove_leftovers(target)
        _sync_folder(target.parent)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}", Location(str(path))
        ) from error


def _write_beside(target: Path, data: bytes) -> Path:
    """Write `data` to a new file in the folder of `target`, with the mode of `target`."""
    temporary, descriptor = _create_beside(target)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            with contextlib.suppress(FileNotFoundError):
                os.fchmod(stream.fileno(), stat.S_IMODE(target.stat().st_mode))
            os.fsync(stream.fileno())
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return temporary


def _create_beside(target: Path) -> tuple[Path, int]:
    """Create a file of a name not taken; the mode for a new file is the user's own default."""
    number = 0
    while True:
        temporary = target.with_name(f".{target.name}.{os.getpid()}-{number}.tmp")
        try:
            return temporary, os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            number += 1


def _remove_leftovers(target: Path) -> None:
    """Remove what killed writers of this file left beside it."""
    pattern = re.compile(rf"\.{re.escape(target.name)}\.(\d+)-\d+\.tmp")
    with os.scandir(target.parent) as entries:
        found = [
            (entry.path, match) for entry in entries if (match := pattern.fullmatch(entry.name))
        ]
    for path, match in found:
        if not _is_running(int(match[1])):
            Path(path).unlink(missing_ok=True)


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
