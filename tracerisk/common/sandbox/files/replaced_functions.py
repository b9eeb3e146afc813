"""Python's functions for files: where each is bound, and what may stand in its place."""

from __future__ import annotations

import builtins
import contextlib
import functools
import io
import os
import pathlib
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tracerisk.common.sandbox.files.held_files import has_opener

OS_NAMES = (
    *("access", "chdir", "chmod", "link", "listdir", "lstat", "mkdir", "mkfifo", "open"),
    *("readlink", "remove", "rename", "replace", "rmdir", "scandir", "stat", "symlink"),
    *("truncate", "unlink", "utime"),
)
"""The functions of `os` that take the path of a file."""
_inside = threading.local()


def is_inside() -> bool:
    """Return whether this thread runs what stands in the place of a function."""
    return bool(getattr(_inside, "is_so", False))


@contextlib.contextmanager
def inside() -> Iterator[None]:
    """Call the real functions within."""
    _inside.is_so = True
    try:
        yield
    finally:
        _inside.is_so = False


def places_of(functions: Mapping[str, Callable[..., Any]]) -> Iterator[tuple[Any, str, Any]]:
    """Yield each place where a function for files is bound, with what is to be put there.

    A place is its owner and its name there. `functions` has `io.open` and those of `OS_NAMES`.
    """
    yield from ((owner, "open", functions["io.open"]) for owner in (builtins, io))
    yield from ((os, name, functions[name]) for name in OS_NAMES)
    # Python 3.10 has bound them there.
    accessor = getattr(pathlib, "_NormalAccessor", None)
    bound = {} if accessor is None else {**functions, "open": functions["io.open"]}
    for name, item in bound.items():
        if name in vars(accessor):
            yield accessor, name, staticmethod(item)
    yield from _kept_by_numpy(functions["io.open"])


def standing_for(
    real: Callable[..., Any],
    function: Callable[..., Any],
    on_error: Callable[[OSError, tuple[Any, ...]], None],
) -> Callable[..., Any]:
    """Return a plain function that stands for a real one, but for what it calls itself."""

    @functools.wraps(real)
    def replacement(*args: Any, **more: Any) -> Any:
        # What an opener calls is redirected by itself.
        if is_inside() or has_opener(args[1:], more):
            return real(*args, **more)
        _inside.is_so = True
        try:
            return function(*args, **more)
        except OSError as error:
            on_error(error, args)
            raise
        finally:
            _inside.is_so = False

    return replacement


class Entries:
    """What `os.scandir` returns: entries, to be closed."""

    def __init__(self, entries: list[Any]) -> None:
        self._entries = iter(entries)

    def __iter__(self) -> Iterator[Any]:
        return self

    def __next__(self) -> Any:
        return next(self._entries)

    def __enter__(self) -> Entries:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Do nothing: all was read."""


def _kept_by_numpy(opens: Callable[..., Any]) -> Iterator[tuple[Any, str, Any]]:
    """Yield what replaces the function with which NumPy reads and writes texts, if it is there."""
    source = sys.modules.get("numpy.lib._datasource")
    openers = getattr(source, "_file_openers", None)
    kept = getattr(openers, "_file_openers", None)
    if isinstance(kept, dict):
        yield openers, "_file_openers", {**kept, None: opens}
