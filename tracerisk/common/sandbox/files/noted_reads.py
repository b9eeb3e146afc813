"""Which files below some folders a process opens."""

from __future__ import annotations

import contextlib
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
_DATABASE = "sqlite3.connect"
_CACHES = frozenset({"__pycache__", "node_modules", "site-packages", "dist-packages"})
_CODE = (".py", ".pyc", ".pyi", ".so")

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

    Those with one of the `endings` are noted by who reads them alone, with `add`. Below `data`,
    files count that are neither code nor hidden, in no cache and below none of the folders `apart`,
    and that a controller reads: what the tool looks through on its own does not decide the run.
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
        self._data = _beginnings(name for path in data for name in (path, path.resolve()))
        self._apart = _beginnings(apart)
        self._noted: dict[str, None] = {}
        self._written: set[str] = set()

    def add(self, path: Path) -> None:
        """Note a file, if it lies below the folders."""
        if str(path).startswith(self._folders):
            self._note(str(path))

    def watch(self) -> None:
        """Note each file that is opened from now on, until the process ends."""
        if self._folders or self._data:
            listen(("open", _DATABASE), self._opened)

    def files(self) -> list[str]:
        """Return the files that were noted and are there, sorted."""
        return sorted(path for path in self._noted if Path(path).is_file())

    def _opened(self, event: str, arguments: tuple[Any, ...]) -> None:
        if _is_apart.get():
            return
        if not isinstance(arguments[0], str | bytes):
            return
        if not (path := _full(arguments[0])).startswith((*self._folders, *self._data)):
            return
        flags = arguments[2] if event == "open" else 0
        if isinstance(flags, int) and flags & _WRITES:
            self._written.add(path)
        elif path not in self._written and not path.endswith(self._endings) and self._counts(path):
            self._note(path)

    def _counts(self, path: str) -> bool:
        return path.startswith(self._folders) or self._is_data(path)

    def _is_data(self, path: str) -> bool:
        if path.startswith(self._apart) or path.endswith(_CODE):
            return False
        if self._is_of_tool():
            return False
        folder = max((name for name in self._data if path.startswith(name)), key=len)
        parts = Path(path.removeprefix(folder)).parts
        return not any(part.startswith(".") or part in _CACHES for part in parts)

    def _is_of_tool(self) -> bool:
        """Return whether the tool opens a file by itself, and no controller or stand-in."""
        frame: FrameType | None = _frame_of(1)
        while frame is not None:
            name = frame.f_code.co_filename
            if name.startswith(_TOOL):
                if not name.startswith(_BETWEEN):
                    return not name.startswith(_FOR_CONTROLLERS)
            elif name.startswith(self._data) and _CACHES.isdisjoint(Path(name).parts):
                return False
            frame = frame.f_back
        return False

    def _note(self, path: str) -> None:
        if len(self._noted) < _MOST_NOTED:
            self._noted.setdefault(path)


def _beginnings(folders: Iterable[Path]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(f"{folder}{os.sep}" for folder in folders))


def _full(path: str | bytes) -> str:
    text = os.fsdecode(path)
    try:
        return os.path.abspath(text)  # noqa: PTH100 - links are not followed
    except OSError:  # the current folder is gone
        return text
