"""What a campaign has tried, a line each as it comes, so that a killed one goes on from there."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from tracerisk.errors import InputError, Location
from tracerisk.pipeline.freshness.trace_cache import make_kept


def journaled(path: Path) -> list[str]:
    """Return the lines that are kept; the last one may have been cut by a kill."""
    try:
        return path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return []


@contextlib.contextmanager
def journal(path: Path) -> Iterator[Callable[[Iterable[str]], None]]:
    """Yield what keeps lines in a file of the cache.

    Raises InputError where that cannot be written.
    """

    def write(text: str) -> None:
        try:
            make_kept(path.parent)
            with path.open("a", encoding="utf-8") as stream:
                stream.write(text)
        except OSError as error:
            raise InputError(
                f"cannot be written: {error.strerror}; what was tried before is kept",
                Location(str(path)),
            ) from error

    # A line that a kill has cut stays one of its own.
    write("\n" if path.exists() and path.stat().st_size else "")
    yield lambda lines: write("".join(f"{line}\n" for line in lines))
