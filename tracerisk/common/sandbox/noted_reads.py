"""Which files below some folders a process opens."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

_WRITES = os.O_WRONLY | os.O_RDWR
_MOST_NOTED = 1000


class NotedReads:
    """The files below `folders` that this process reads, from when it is watched.

    Those with one of the `endings` are noted by who reads them alone, with `add`.
    """

    def __init__(self, folders: Iterable[Path], endings: tuple[str, ...] = ()) -> None:
        self._folders = tuple(f"{folder}{os.sep}" for folder in folders)
        self._endings = endings
        self._noted: dict[str, None] = {}

    def add(self, path: Path) -> None:
        """Note a file, if it lies below the folders."""
        self._note(str(path))

    def watch(self) -> None:
        """Note each file that is opened from now on, until the process ends."""
        if self._folders:
            sys.addaudithook(self._opened)

    def files(self) -> list[str]:
        """Return the files that were noted and are there, sorted."""
        return sorted(path for path in self._noted if Path(path).is_file())

    def _opened(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or not isinstance(arguments[0], str):
            return
        path, _, flags = arguments
        is_written = isinstance(flags, int) and flags & _WRITES
        if not is_written and not path.endswith(self._endings):
            self._note(path)

    def _note(self, path: str) -> None:
        if path.startswith(self._folders) and len(self._noted) < _MOST_NOTED:
            self._noted.setdefault(path)
