"""What a campaign has tried, a line each as it comes, so that a killed one goes on from there."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from tracerisk.common.text.bounded import MOST_WRITTEN, file_text
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.freshness.trace_cache import make_kept


def journaled(path: Path) -> list[str]:
    """Return the lines that are kept; the last one may have been cut by a kill."""
    try:
        return file_text(path, most=MOST_WRITTEN).splitlines()
    except (OSError, UnicodeDecodeError):
        return []


@contextlib.contextmanager
def journal(path: Path) -> Iterator[Callable[[Iterable[str]], None]]:
    """Yield what keeps lines in a file of the cache.

    Raises InputError where that cannot be written.
    """
    try:
        make_kept(path.parent)
    except OSError as error:
        raise _not_written(path, error) from error
    # A line that a kill has cut stays one of its own.
    _append(path, "\n" if path.exists() and path.stat().st_size else "")
    yield partial(keep_lines, path)


def keep_lines(path: Path, lines: Iterable[str]) -> None:
    """Add lines to a journal that is there, from any process: a kill leaves each whole or not.

    Raises InputError where it cannot be written.
    """
    _append(path, "".join(f"{line}\n" for line in lines))


def _append(path: Path, text: str) -> None:
    try:
        with path.open("ab", buffering=0) as stream:
            stream.write(text.encode())
    except OSError as error:
        raise _not_written(path, error) from error


def _not_written(path: Path, error: OSError) -> InputError:
    return InputError(
        f"cannot be written: {error.strerror}; what was tried before is kept", Location(str(path))
    )
