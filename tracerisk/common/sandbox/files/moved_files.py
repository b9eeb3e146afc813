"""Files that a controller names by a path of its author's machine, found in the workspace here.

Such a path ends with a package and what lies in it: `/home/ann/ws/src/arm_description/arm.urdf`.
Where it leads to nothing, the package of that name in the workspace is looked into. Where it names
none, and its folder is not on this machine, its end is looked for where authors start a program:
`data/path.txt`, else `path.txt`, of `/home/ann/homework/data/path.txt`.

A relative path, or one below the working directory, that leads to nothing is looked for where
authors start a program: beside it, and at the top of its package and project.

A build puts files of a package elsewhere than its sources have them. One that is asked for below a
package, and is not there, is the only one of its name in that package, if the rules by which the
package is installed name it or its folder.

Folders stay as they are: who finds one lacking makes it, or looks elsewhere.
"""

from __future__ import annotations

import builtins
import functools
import io
import os
import stat
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from types import FrameType
from typing import Any

from tracerisk.common.replaced_names import replaced
from tracerisk.common.text.bounded import file_text

_LOOKED_AT = ("stat", "lstat", "access", "open")
_REMOVES = ("remove", "unlink")
_OURS = f"{Path(__file__).parents[3]}/"
_STAND_INS = f"{_OURS}ros/stand_ins/"
_PYTHON = (f"{Path(os.__file__).parent}/", "<frozen ")
_MODULES = (".py", ".pyc", ".so")
_PASSING = ("/tmp/", "/var/", "/run/")
_RULES = ("setup.py", "CMakeLists.txt")
_BUILT = frozenset({"build", "install", "devel", "log", "__pycache__"})
_MOST_FILES = 2000  # of a package, through which one of a name is looked for
_SYSTEM = ("/dev/", "/proc/", "/sys/", "/etc/", "/usr/", "/lib")


class MovedFiles:
    """The folders of a workspace by the names that they have on every machine.

    What lies below `top`, the folder around all of them, or in this Python's own folders is of
    this machine. In `starts` its author may start the program, the likeliest first. `on_found` is
    called once for each path that was found elsewhere, with both places.
    """

    def __init__(
        self,
        folders: Mapping[str, Path],
        top: Path,
        on_found: Callable[[str, str], None],
        starts: Sequence[Path] = (),
    ) -> None:
        self._folders = {name: str(folder) for name, folder in folders.items()}
        own = (f"{top}/", f"{sys.prefix}/", f"{sys.base_prefix}/")
        self._of_here = (*_SYSTEM, *own)
        self._starts = tuple(map(str, starts))
        self._on_found = on_found
        self._found: dict[str, str] = {}
        self._gone: set[str] = set()
        self._stat, self._lstat = os.stat, os.lstat

    def _is_there(self, path: str, *, as_file: bool = False) -> bool:
        try:
            row = self._stat(path) if as_file else self._lstat(path)
        except (OSError, ValueError):
            return False
        return not as_file or stat.S_ISREG(row.st_mode)

    def place(self, path: Any) -> Any:
        """Return where to read a file: at its path, if it is there or nothing here is like it."""
        if not isinstance(path, str | os.PathLike):
            return path
        text = os.fspath(path)
        if not isinstance(text, str) or not text:
            return path
        relative, package = self._from_start(text), self._package_of(text)
        if not relative and not package and text.startswith(self._of_here):
            return path
        if text in self._gone or self._is_there(text):
            return path
        if text not in self._found:
            here = self._beside(relative) if relative else None
            if here is None and package:
                here = self._before_install(package, text)
            elif here is None and not relative:
                here = self._here(text)
            if here is None or _is_asked_by_us():
                return path
            self._found[text] = here
            self._on_found(text, here)
        return self._found[text]

    def _from_start(self, text: str) -> str:
        """Return a path from the working directory, if it is one below it; else empty."""
        # Modules are the import system's to find.
        if not self._starts or text.endswith(_MODULES):
            return ""
        if not text.startswith("/"):
            return text
        try:
            here = f"{os.getcwd()}/"  # noqa: PTH109 - the text of a path is compared
        except OSError:  # the directory is no more
            return ""
        return text[len(here) :] if text.startswith(here) else ""

    def _beside(self, relative: str) -> str | None:
        places = (f"{folder}/{relative}" for folder in self._starts)
        return next((place for place in places if self._is_there(place, as_file=True)), None)

    def _package_of(self, text: str) -> str:
        """Return the folder of the package that a file lies below, empty where there is none."""
        if text.endswith(_MODULES):
            return ""
        below = (folder for folder in self._folders.values() if text.startswith(f"{folder}/"))
        return max(below, key=len, default="")

    def _before_install(self, package: str, text: str) -> str | None:
        """Return where the sources of a package have a file that a build puts elsewhere."""
        name, rules = text.rpartition("/")[2], "\n".join(self._rules(package))
        if not rules:
            return None
        paths: list[str] = []
        count = 0
        for folder, folders, files in os.walk(package):
            folders[:] = sorted(one for one in folders if one not in _BUILT and one[:1] != ".")
            count += len(files)
            if count > _MOST_FILES or len(paths) > 1:
                return None
            if name in files:
                paths.append(f"{folder}/{name}")
        if len(paths) != 1 or not self._is_there(paths[0], as_file=True):
            return None
        above = Path(paths[0]).parent.name
        return paths[0] if name in rules or above in rules else None

    def _rules(self, package: str) -> Iterator[str]:
        for rules in _RULES:
            if self._is_there(f"{package}/{rules}", as_file=True):
                yield file_text(f"{package}/{rules}", errors="replace")

    def _here(self, text: str) -> str | None:
        parts = [part for part in text.split("/") if part]
        # `share/arm/config` lies below another folder `arm` of an installation.
        for index in range(len(parts) - 1, 0, -1):
            folder = self._folders.get(parts[index])
            here = "/".join((folder or "", *parts[index + 1 :]))
            if folder and self._is_there(here, as_file=True):
                return here
        # Settings of a library are hidden in a home; a folder that is here is no other machine's.
        is_of_here = text.startswith(_PASSING) or "/." in text or text.endswith(_MODULES)
        if is_of_here or not parts or self._is_there(f"/{'/'.join(parts[:-1])}"):
            return None
        ends = ("/".join(parts[index:]) for index in range(1, len(parts)))
        return next((place for end in ends if (place := self._beside(end)) is not None), None)

    def active(self) -> AbstractContextManager[None]:
        """Look there while this is open."""
        owners = [(builtins, "open"), (io, "open"), *((os, name) for name in _LOOKED_AT)]
        return replaced(
            [
                *((owner, name, self._looking(getattr(owner, name))) for owner, name in owners),
                *((os, name, self._removing(getattr(os, name))) for name in _REMOVES),
            ]
        )

    def _removing(self, real: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function for which what was found elsewhere is gone then, and stays there."""

        @functools.wraps(real)
        def removing(path: Any, *args: Any, **more: Any) -> Any:
            text = os.fspath(path)
            if text not in self._found or text in self._gone or self._is_there(text):
                return real(path, *args, **more)
            self._gone.add(text)
            return None

        return removing

    def _looking(self, real: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(real)
        def looking(path: Any, *args: Any, **more: Any) -> Any:
            how = args[0] if args else more.get("mode", more.get("flags", ""))
            is_written = real.__name__ == "open" and _writes(how)
            return real(path if is_written else self.place(path), *args, **more)

        return looking


def _is_asked_by_us() -> bool:
    """Return whether our own code looks for a file, for itself and not in a controller's name."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and _passes_on(frame.f_code.co_filename):
        frame = frame.f_back
    asking = "" if frame is None else frame.f_code.co_filename
    return asking.startswith(_OURS) and not asking.startswith(_STAND_INS)


def _passes_on(file: str) -> bool:
    """Return whether code of a file only hands a path on: that of Python, and of this module."""
    return file == __file__ or (file.startswith(_PYTHON) and not file.startswith(_OURS))


def _writes(how: object) -> bool:
    if isinstance(how, int):
        return bool(how & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))
    return isinstance(how, str) and any(name in how for name in "wax+")
