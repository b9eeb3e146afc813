"""Which files a process opens: data below some folders, and code from wherever it is loaded."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path
from types import FrameType
from typing import Any

from tracerisk.common.sandbox.files.audit_events import listen

_WRITES = os.O_WRONLY | os.O_RDWR
_MOST_NOTED = 1000
_PATH_AT = {"open": 0, "sqlite3.connect": 0, "import": 1, "ctypes.dlopen": 0}
"""Which argument of an event of Python's names a file, by the event."""
_LIBRARY_EVENTS = frozenset({"import", "ctypes.dlopen"})
"""The events by which a compiled library is loaded."""
_CACHE = "__pycache__"
_CACHES = frozenset({_CACHE, "node_modules", "site-packages", "dist-packages"})
_CODE = (".pyc", ".pyi", ".so")
_IMPORTERS = ("<frozen importlib", "<frozen zipimport", "<frozen runpy")

_TOOL = f"{Path(__file__).parents[3]}{os.sep}"
_BETWEEN = tuple(f"{_TOOL}common{os.sep}{name}{os.sep}" for name in ("sandbox", "text"))
_FOR_CONTROLLERS = tuple(
    f"{_TOOL}ros{os.sep}{name}" for name in ("stand_ins", f"graph{os.sep}parameter_files.py")
)

_frame_of = sys._getframe
"""Returns a frame; the controller gets another in its place, which hides those of the tool."""
_is_apart: ContextVar[bool] = ContextVar("is_apart", default=False)


@contextlib.contextmanager
def unnoted() -> Iterator[None]:
    """Note nothing that is read within: on it depends nothing that the process does."""
    token = _is_apart.set(True)
    try:
        yield
    finally:
        _is_apart.reset(token)


class NotedReads:
    """The files below `folders` that this process reads, from when it is watched.

    Those with one of the `endings` are noted by who reads them alone, with `add`. Of `data`, which
    are files and folders, files count that are not compiled, in no cache or hidden folder, below
    none of the folders `apart`, and that a controller reads: what the tool looks through on its own
    does not decide the run. Code that Python loads counts wherever it is, but below `apart`: of a
    source the source, of an archive the archive.
    What the process has written before it reads it counts nowhere.
    """

    def __init__(
        self,
        folders: Iterable[Path],
        endings: tuple[str, ...] = (),
        *,
        data: Iterable[Path] = (),
        apart: Iterable[Path] = (),
    ) -> None:
        self._folders = _beginnings(folders)
        self._endings = endings
        named = [name for path in data for name in (path, path.resolve())]
        self._data = _beginnings(named)
        self._files_of_data = frozenset(map(str, named))
        self._apart = _beginnings(apart)
        self._noted: dict[str, None] = {}
        self._written: set[str] = set()

    def add(self, path: Path) -> None:
        """Note a file, if it lies below the folders."""
        if str(path).startswith(self._folders):
            self._note(str(path))

    def watch(self) -> None:
        """Note each file that is opened from now on, until the process ends."""
        listen(_PATH_AT, self._opened)

    def files(self) -> list[str]:
        """Return the files that were noted and are there, sorted."""
        return sorted(path for path in self._noted if Path(path).is_file())

    def _opened(self, event: str, arguments: tuple[Any, ...]) -> None:
        if _is_apart.get():
            return
        named = arguments[_PATH_AT[event]]
        if not isinstance(named, str | bytes):
            return
        path = _full(named)
        flags = arguments[2] if event == "open" else 0
        if isinstance(flags, int) and flags & _WRITES:
            if path in self._files_of_data or path.startswith((*self._folders, *self._data)):
                self._written.add(path)
        elif path in self._written:
            return
        elif path.startswith(self._folders):
            if not path.endswith(self._endings):
                self._note(path)
        elif event in _LIBRARY_EVENTS:
            if os.fsdecode(named).count(os.sep) and not self._is_apart(path):
                self._note(path)
        elif _is_imported():
            if not self._is_apart(path):
                self._note(_source_of(path))
        elif self._is_data(path):
            self._note(path)

    def _is_data(self, path: str) -> bool:
        if path.endswith((*self._endings, *_CODE)) or path.startswith(self._apart):
            return False
        if path not in self._files_of_data and not path.startswith(self._data):
            return False
        if self._is_of_tool():
            return False
        folder = max((name for name in self._data if path.startswith(name)), key=len, default="")
        parts = Path(path.removeprefix(folder)).parts if folder else ()
        return not any(part.startswith(".") or part == _CACHE for part in parts[:-1])

    def _is_apart(self, path: str) -> bool:
        return path.startswith(self._apart) or os.path.realpath(path).startswith(self._apart)

    def _is_of_tool(self) -> bool:
        """Return whether the tool opens a file by itself, and no controller or stand-in."""
        frame: FrameType | None = _frame_of(1)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(_TOOL):
                if not name.startswith(_BETWEEN):
                    return not name.startswith(_FOR_CONTROLLERS)
            elif self._is_of_controller(name):
                return False
            frame = frame.f_back
        return False

    def _is_of_controller(self, name: str) -> bool:
        is_within = name.startswith(self._data) and not name.startswith(self._apart)
        return is_within and _CACHES.isdisjoint(Path(name).parts)

    def _note(self, path: str) -> None:
        if len(self._noted) < _MOST_NOTED:
            self._noted.setdefault(path)


def _beginnings(folders: Iterable[Path]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(f"{folder}{os.sep}" for folder in folders))


def _is_imported() -> bool:
    """Return whether it is Python that opens a file, to load code from it."""
    frame: FrameType | None = _frame_of(1)
    while frame is not None and frame.f_code.co_filename.startswith(_BETWEEN):
        frame = frame.f_back
    return frame is not None and frame.f_code.co_filename.startswith(_IMPORTERS)


def _source_of(path: str) -> str:
    """Return the source of a compiled file that Python keeps beside it, else the file itself."""
    if _CACHE not in Path(path).parts:
        return path
    try:
        source = importlib.util.source_from_cache(path)
    except ValueError:
        return path
    return source if Path(source).is_file() else path


def _full(path: str | bytes) -> str:
    text = os.fsdecode(path)
    try:
        return os.path.abspath(text)  # noqa: PTH100 - links are not followed
    except OSError:  # the current folder is gone
        return text
