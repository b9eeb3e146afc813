"""The folders of a run: what is recorded, how far it has come, and what the controller writes."""

from __future__ import annotations

import contextlib
import errno
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

from tracerisk import errors
from tracerisk.common.sandbox.scratch import new_scratch, remove_scratch
from tracerisk.errors import Location
from tracerisk.pipeline.trace.run_files import MOST_ROWS, MOST_TEXT
from tracerisk.twin.recording.samples import simulated_ns


@contextlib.contextmanager
def run_folders(keep: Path | None) -> Iterator[tuple[Path, Path]]:
    """Yield the folders of a run: that of its recording, and that of what the controller writes.

    Both are gone afterwards; what was recorded goes into `keep`.
    """
    if keep is not None:
        try:
            keep.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            message = f"is not a folder that a recording can be kept in: {error.strerror}"
            raise errors.InputError(message, Location(str(keep))) from error
    top = new_scratch()
    recording, written = top / "recording", top / "written"
    try:
        recording.mkdir()
        written.mkdir()
        yield recording, written
    finally:
        try:
            if keep is not None:
                keep_recording(recording, keep)
        finally:
            remove_scratch(top)


def keep_recording(recording: Path, keep: Path) -> None:
    """Copy what was recorded; a controller's process can put anything beside it, or in its place.

    Raises InputError where the folder cannot be written.
    """
    try:
        for path in sorted(recording.iterdir()):
            if not path.is_symlink() and path.is_file():
                (keep / path.name).unlink(missing_ok=True)
                shutil.copyfile(path, keep / path.name, follow_symlinks=False)
    except OSError as error:
        if error.errno == errno.ENOSPC:
            raise errors.disk_full(str(keep)) from error
        message = f"cannot keep the recording: {error.strerror}"
        raise errors.InputError(message, Location(str(keep))) from error


def check_left(folder: Path) -> None:
    """Raise LogError at what is not a regular file of a recording, LimitError at a too large one.

    Of a folder that is gone there is nothing to say: its recording is empty.
    """
    if not folder.is_dir():
        return
    for path in sorted(folder.iterdir()):
        status = path.lstat()
        if not stat.S_ISREG(status.st_mode):
            raise errors.LogError(
                f"{path.name} of the recording is not a regular file: the controller's process has "
                "put it there",
            )
        if status.st_size > (MOST_ROWS if path.suffix == ".bin" else MOST_TEXT):
            raise errors.LimitError(
                f"the run left {path.name} with {status.st_size} bytes, more than are read; "
                "let it end earlier, with --duration"
            )


def size_of(path: Path) -> int:
    """Return the size of a file [bytes], -1 of one that is not there."""
    try:
        return path.stat().st_size
    except OSError:
        return -1


def simulated_so_far(folder: Path) -> int:
    """Return how far a run has come that is being recorded [ns], -1 where its folder is gone."""
    try:
        return simulated_ns(folder)
    except OSError:  # removed while it was looked at
        return -1
