"""Files that a contained process may read, as they were when it began.

The kernel lets a process read a file, not a name. What an editor saves under the name of a file is
another file, by renaming, and nobody has allowed that one. So each file that is allowed by itself,
and not with its folder, is held; where its name leads to what is refused, the held one is opened.
"""

from __future__ import annotations

import _io
import builtins
import contextlib
import functools
import io
import os
import pathlib
import stat
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

_MOST = 256
"""How many files are held at most: each takes a descriptor."""
_PATIENCE_S = 0.1
"""How long all files together are waited for that are between two names."""


def hold(paths: Iterable[str]) -> dict[str, str]:
    """Hold the regular files among `paths`; return where each is held, by its path.

    A file of which nothing has the name is being saved by an editor, which is waited for.
    """
    held: dict[str, str] = {}
    deadline_s = time.monotonic() + _PATIENCE_S
    for path in paths:
        if len(held) == _MOST:
            break
        descriptor = _descriptor(path, deadline_s)
        if descriptor is None:
            continue
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            held[path] = f"/proc/self/fd/{descriptor}"
        else:
            os.close(descriptor)
    return held


def _descriptor(path: str, deadline_s: float) -> int | None:
    while True:
        try:
            return os.open(path, os.O_PATH | os.O_CLOEXEC)
        except FileNotFoundError:
            if time.monotonic() > deadline_s:
                return None
            time.sleep(0.001)
        except OSError:
            return None


def serve(held: Mapping[str, str]) -> None:
    """Open from now on the held file where its name leads to one that is refused."""
    if not held:
        return
    io_open, os_open = _serving(io.open, held), _serving(os.open, held)
    builtins.open = io.open = io_open
    os.open = os_open
    # An import opens a source by this name of the module behind `io`.
    io.open_code = _io.open_code = _serving(io.open_code, held)
    # Python 3.10 has bound them there.
    accessor = getattr(pathlib, "_NormalAccessor", None)
    if accessor is not None:
        accessor.open = staticmethod(io_open)


def _serving(real: Callable[..., Any], held: Mapping[str, str]) -> Callable[..., Any]:
    @functools.wraps(real)
    def opened(file: Any, *args: Any, **more: Any) -> Any:
        try:
            return real(file, *args, **more)
        except PermissionError:
            # An opener opens by `os.open`, which is served by itself.
            place = None if has_opener(args, more) else _place(file, more.get("dir_fd"), held)
            if place is not None:
                with contextlib.suppress(OSError):
                    return real(place, *args, **more)
            raise

    return opened


def has_opener(args: Sequence[Any], more: Mapping[str, Any]) -> bool:
    """Return whether `open` is given what opens the file; `args` are those after its name."""
    return more.get("opener", args[6] if len(args) > 6 else None) is not None


def _place(file: Any, folder: int | None, held: Mapping[str, str]) -> str | None:
    """Return where a file is held, by any of its names; `None` where it is not.

    `folder` is the descriptor of the folder in which the name is looked up, if not the current one.
    """
    try:
        path = Path("" if folder is None else f"/proc/self/fd/{folder}", os.fsdecode(file))
        return held.get(str(path.parent.resolve() / path.name))
    except (TypeError, ValueError, OSError, RuntimeError):
        return None
