"""Files that a controller names by a path of its author's machine, found in the workspace here.

Such a path ends with a package and what lies in it: `/home/ann/ws/src/arm_description/arm.urdf`.
Where it leads to nothing, the package of that name in the workspace is looked into.
"""

from __future__ import annotations

import builtins
import contextlib
import functools
import io
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

_LOOKED_AT = ("stat", "lstat", "access", "listdir", "scandir", "open")
_SYSTEM = ("/dev/", "/proc/", "/sys/", "/etc/", "/usr/", "/lib")


class MovedFiles:
    """The folders of a workspace by the names that they have on every machine.

    What lies below `top`, the folder around all of them, or in this Python's own folders is of
    this machine. `on_found` is called once for each path that was found elsewhere, with both
    places.
    """

    def __init__(
        self, folders: Mapping[str, Path], top: Path, on_found: Callable[[str, str], None]
    ) -> None:
        self._folders = {name: str(folder) for name, folder in folders.items()}
        own = (f"{top}/", f"{sys.prefix}/", f"{sys.base_prefix}/")
        self._of_here = (*_SYSTEM, *own)
        self._on_found = on_found
        self._found: dict[str, str] = {}
        self._lstat = os.lstat

    def _is_there(self, path: str) -> bool:
        try:
            self._lstat(path)
        except (OSError, ValueError):
            return False
        return True

    def place(self, path: Any) -> Any:
        """Return where to look for a path: itself, if it is there or nothing here is like it."""
        if not isinstance(path, str | os.PathLike):
            return path
        text = os.fspath(path)
        if not isinstance(text, str) or not text.startswith("/") or text.startswith(self._of_here):
            return path
        if text not in self._found and not self._is_there(text):
            parts = [each for each in text.split("/") if each]
            # `share/arm/config` lies below another folder `arm` of an installation.
            for index in range(len(parts) - 1, 0, -1):
                folder = self._folders.get(parts[index])
                here = folder and "/".join((folder, *parts[index + 1 :]))
                if here and here != text and self._is_there(here):
                    self._found[text] = here
                    self._on_found(text, here)
                    break
        return self._found.get(text, path)

    @contextlib.contextmanager
    def active(self) -> Iterator[None]:
        """Look there while this is open."""
        owners = [(builtins, "open"), (io, "open"), *((os, name) for name in _LOOKED_AT)]
        before = [(owner, name, getattr(owner, name)) for owner, name in owners]
        try:
            for owner, name, real in before:
                setattr(owner, name, self._looking(real))
            yield
        finally:
            for owner, name, real in before:
                setattr(owner, name, real)

    def _looking(self, real: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(real)
        def looking(path: Any = ".", *args: Any, **more: Any) -> Any:
            how = args[0] if args else more.get("mode", more.get("flags", ""))
            is_written = real.__name__ == "open" and _writes(how)
            return real(self._target(path) if is_written else self.place(path), *args, **more)

        return looking

    def _target(self, path: Any) -> Any:
        """Return where to write: what is new stays where it is meant, if its folder is there."""
        if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str):
            return path
        folder, name = os.path.split(os.fspath(path))
        there = self.place(folder)
        return path if there == folder else f"{there}/{name}"


def _writes(how: object) -> bool:
    if isinstance(how, int):
        return bool(how & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))
    return isinstance(how, str) and any(each in how for each in "wax+")
