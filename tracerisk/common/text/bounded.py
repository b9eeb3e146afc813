"""Read files, folders, numbers and JSON that others wrote, within bounds of size and depth.

What is past a bound is a `ValueError` like any other malformed text, so that a reader needs one
kind of refusal: Python itself raises OverflowError, RecursionError, or reads `1e999` as infinite.
A file that is none, or too large, is an `OSError` like any other that cannot be read.
What others delete while it is looked for is not there: `pathlib` itself would raise for a folder.
"""

from __future__ import annotations

import errno
import math
import os
import stat

from tracerisk.errors import InputError, Location

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Collection
    from pathlib import Path
    from typing import Any, BinaryIO

    Pairs = list[tuple[str, Any]]

MOST_DIGITS = 400
"""The digits of the longest number that is read; the largest double has 309."""

MOST_BYTES = 2**24
"""The bytes of the largest file that is read, where its reader states no other number."""

MOST_WRITTEN = 2**28
"""The same of a file that tracerisk writes for a whole workspace: a lock, a trace, a report."""

MOST_OF_A_RUN = 2**32
"""The same of what the process of a run writes."""

# Windows has no pipes in folders, and its own line ends where a file is not opened as binary.
_FLAGS = (
    os.O_RDONLY
    | getattr(os, "O_NONBLOCK", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_NOCTTY", 0)
    | getattr(os, "O_BINARY", 0)
)
_PIECE = 2**16


class NoFileError(InputError, OSError):
    """A device, a pipe or a file that is too large stands where a file is to be read."""

    def __init__(self, number: int, words: str, path: str | os.PathLike[str]) -> None:
        super().__init__(f"cannot be read: {words}", Location(os.fspath(path)))
        self.errno, self.strerror, self.filename = number, words, os.fspath(path)


def whole_number(text: str) -> int:
    """Return the whole number that `text` states; raise ValueError if it is none, or too long."""
    _check_length(text)
    return int(text)


def finite_number(text: str) -> float:
    """Return the number that `text` states; raise ValueError if it is none, or not finite."""
    _check_length(text)
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"a number is not finite: {text[:20]}")
    return value


def _check_length(text: str) -> None:
    if len(text) > MOST_DIGITS:
        raise ValueError(f"a number of {len(text)} digits; at most {MOST_DIGITS} are allowed")


def loads_json(
    text: str | bytes, *, object_pairs_hook: Callable[[Pairs], Any] | None = None
) -> Any:
    """Return what a JSON text states.

    Raises ValueError (JSONDecodeError, with the place, where the text is not JSON) for numbers that
    are too long or not finite, and for a text that nests too deeply.
    """
    import json  # what reads no JSON starts without it

    try:
        return json.loads(
            text,
            parse_int=whole_number,
            parse_float=finite_number,
            parse_constant=finite_number,
            object_pairs_hook=object_pairs_hook,
        )
    except RecursionError as error:
        raise ValueError("it nests too deeply") from error


def file_bytes(
    path: str | os.PathLike[str], most: int = MOST_BYTES, *, through_links: bool = True
) -> bytes:
    """Return what a regular file holds.

    Raises OSError where it cannot be opened, is a device, a pipe or a folder, or holds more than
    `most` bytes; a link too, unless it is to be read `through_links`. Nothing is waited for.
    """
    with regular_file(path, through_links=through_links) as stream:
        data = read_within(stream, most)
    if data is None:
        words = f"it holds more than {most} bytes, and no larger file is read"
        raise NoFileError(errno.EFBIG, words, path)
    return data


def read_within(stream: BinaryIO, most: int) -> bytes | None:
    """Return what is left of a file that was just opened; `None` where that is more than `most`."""
    size = os.fstat(stream.fileno()).st_size  # a pipe has none, and may have no end
    if size > most:
        return None
    parts = [stream.read(size + 1)]
    count = len(parts[0])
    while count > size and parts[-1] and count <= most:  # it grows, or its size is not known
        parts.append(stream.read(_PIECE))
        count += len(parts[-1])
    return b"".join(parts) if count <= most else None


def file_text(
    path: str | os.PathLike[str],
    encoding: str = "utf-8",
    errors: str = "strict",
    most: int = MOST_BYTES,
) -> str:
    """Return the text of a regular file, line ends as `\n`; raises as `file_bytes` and `decode`."""
    text = file_bytes(path, most).decode(encoding, errors)
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def regular_file(path: str | os.PathLike[str], *, through_links: bool = True) -> BinaryIO:
    """Open a regular file to be read.

    Raises OSError for what is none: a checkout can bring a link to a device without an end, and a
    pipe would keep who opens it waiting.
    """
    descriptor = os.open(path, _FLAGS if through_links else _FLAGS | os.O_NOFOLLOW)
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
        if not stat.S_ISREG(mode):
            kind = "pipe" if stat.S_ISFIFO(mode) else "device"
            words = f"it is a {kind}; put a regular file there"
            raise NoFileError(errno.EINVAL, words, path)
    except BaseException:
        os.close(descriptor)
        raise
    # From here on the stream closes it: a Ctrl-C in between must not become a failed second close.
    return os.fdopen(descriptor, "rb")


def named_file(path: str) -> BinaryIO:
    """Open a file that a command names, which may be a pipe there: `/dev/stdin`, `/dev/fd/63`."""
    if path.startswith("/dev/"):
        return open(path, "rb")  # noqa: PTH123 - no start needs pathlib; who asks closes it
    return regular_file(path)


def in_folder(folder: Path, *endings: str) -> list[Path]:
    """Return what is in a folder, sorted; nothing of one that is not there or cannot be listed.

    With `endings`, only what has a name with one of them.
    """
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries]
    except OSError:
        return []
    return sorted(folder / name for name in names if not endings or name.endswith(endings))


def files_below(top: Path, *endings: str, left_out: Collection[str] = ()) -> list[Path]:
    """Return the files below a folder, with `endings` those whose names have one of them, sorted.

    Hidden folders and those `left_out` are not entered.
    """
    files = []
    for folder, folders, names in os.walk(top):
        folders[:] = [name for name in folders if name[0] != "." and name not in left_out]
        chosen = (name for name in names if not endings or name.endswith(endings))
        paths = (top / folder / name for name in chosen)
        files += [path for path in paths if path.is_file()]
    return sorted(files)


def is_folder(path: Path) -> bool:
    """Whether a path is a folder; a name that is too long for a path is none."""
    try:
        return path.is_dir()
    except OSError:
        return False
