"""Read a SysML v2 file, and of the files beside it those whose packages it names; or a folder."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from tracerisk.common.hardware.source_files import packages_in, sysml_files, sysml_files_in
from tracerisk.common.hardware.sysml.annotations import OF_FAILURES
from tracerisk.common.hardware.sysml.language.name_resolution import Found, Symbol
from tracerisk.common.hardware.sysml.language.parsing import parse
from tracerisk.common.hardware.sysml.language.standard_names import standard_package
from tracerisk.common.hardware.sysml.language.syntax import Name, SourceText
from tracerisk.common.text.bounded import file_bytes, regular_file
from tracerisk.errors import HardwareError, Location

MAX_BYTES = 16 * 1024 * 1024
"""How long a file may be [bytes]."""

_HEAD = 65_536
_LIBRARY = re.compile(rb"\blibrary\s+package\s+(?:<[^>]*>\s*)?(?:'([^'\n]+)'|(\w+))")


def read_source(path: Path, shown: str) -> SourceText:
    """Return the text of a file.

    Raises HardwareError where it is absent, is not UTF-8, or is larger than 16 MB.
    """
    try:
        with regular_file(path) as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as cause:
        raise HardwareError(f"cannot be read: {cause.strerror}", Location(shown)) from cause
    if len(data) > MAX_BYTES:
        raise HardwareError(f"has more than {MAX_BYTES} bytes; split it", Location(shown))
    try:
        return SourceText(shown, data.decode("utf-8-sig"))
    except UnicodeDecodeError as cause:
        line = data[: cause.start].count(b"\n") + 1
        raise HardwareError("is not UTF-8; save it as UTF-8", Location(shown, line)) from cause


class Project:
    """A file and those beside it, read when a name leads there; or all files below a folder."""

    def __init__(self, path: Path, shown: str) -> None:
        self._path = path
        self._shown = Path(shown)
        self._folder = path if path.is_dir() else path.parent
        self._is_whole = path.is_dir()
        self._found: dict[tuple[str, Name], Found | None] = {}
        self._tops: dict[Path, Symbol] = {}
        self._unread: dict[Path, HardwareError] = {}
        self._packages: dict[Path, frozenset[str]] = {}
        files = [path]
        if self._is_whole:
            files = [item for item in sysml_files(path) if not _is_library(item)]
            if sum(item.stat().st_size for item in files) > MAX_BYTES:
                raise HardwareError(
                    f"its .sysml files have more than {MAX_BYTES} bytes; give the folder of one "
                    "model",
                    Location(shown),
                )
        tops = [self._read_or_note(item) for item in files]
        self.main = tuple(top for top in tops if top is not None)
        """The tops of the files that may declare the system."""
        if not self.main:
            raise next(iter(self._unread.values()))

    @property
    def files(self) -> tuple[Symbol, ...]:
        """The tops of the files that were read so far."""
        return tuple(self._tops.values())

    @property
    def warnings(self) -> tuple[str, ...]:
        """A line for each file of the folder that cannot be read."""
        return tuple(f"{error}; this file is left out" for error in self._unread.values())

    def _read_or_note(self, path: Path) -> Symbol | None:
        """Return the top of a file; `None` for one of a folder that cannot be read.

        Raises HardwareError at the only file, and at one that speaks of failure data, which would
        be lost.
        """
        try:
            return self._read(path)
        except HardwareError as error:
            if not self._is_whole or OF_FAILURES.search(_text(path)):
                raise
            self._unread[path] = error
            return None

    def _read(self, path: Path) -> Symbol:
        if self._is_whole:
            shown = self._shown / path.relative_to(self._folder)
        else:
            shown = self._shown if path == self._path else self._shown.with_name(path.name)
        source = read_source(path, str(shown))
        top = Symbol(parse(source), None, source, partial(self._find, path))
        self._tops[path] = top
        return top

    def _find(self, file: Path, name: Name, asked_at: Location) -> Found | None:
        """Return the element of a qualified name in another file, or the library package.

        Packages of which we know each name go before files.
        Raises HardwareError where several files that are equally near declare it.
        """
        # Files of one folder see the same.
        key = (str(file.parent), name)
        if key not in self._found:
            standard = standard_package(name[0]) if len(name) == 1 else None
            is_known = standard is not None and standard.is_closed
            hit = None if is_known else self._nearest(file, name, asked_at)
            self._found[key] = hit or standard
        return self._found[key]

    def _nearest(self, file: Path, name: Name, asked_at: Location) -> Symbol | None:
        pairs = list(self._declaring(file, name))
        if not pairs:
            return None
        steps = [len(_steps(file.parent, path.parent)) for path, _ in pairs]
        near = [pair for pair, count in zip(pairs, steps, strict=True) if count == min(steps)]
        if len(near) > 1 and len(name) > 1:
            return None
        if len(near) > 1:
            files = " and ".join(path.relative_to(self._folder).as_posix() for path, _ in near)
            where = "in this folder" if self._is_whole else "beside this file"
            raise HardwareError(
                f"package '{name[0]}' is declared by {files} {where}; keep one of them", asked_at
            )
        return near[0][1]

    def _declaring(self, file: Path, name: Name) -> Iterator[tuple[Path, Symbol]]:
        """Yield the other files that have an element of a qualified name, and the element.

        Raises HardwareError at one that declares the package and cannot be read.
        """
        files = [*self._tops, *self._unread] if self._is_whole else sysml_files_in(self._folder)
        for path in files:
            if path == file or name[0] not in self._declared(path):
                continue
            if path in self._unread:
                raise self._unread[path]
            hit: Symbol | None = self._tops.get(path) or self._read(path)
            for segment in name:
                hit = None if hit is None else hit.own(segment)
            if hit is not None:
                yield path, hit

    def _declared(self, path: Path) -> frozenset[str]:
        """Return the names at the top of a file, of one not read yet those of its packages."""
        top = self._tops.get(path)
        if top is not None:
            return frozenset(top.names)
        if path not in self._packages:
            self._packages[path] = _packages(path)
        return self._packages[path]


def _text(path: Path) -> str:
    return file_bytes(path).decode(errors="replace")


def _packages(path: Path) -> frozenset[str]:
    """Return the packages of a file that is worth reading for them."""
    try:
        is_read = path.is_file() and path.stat().st_size <= MAX_BYTES and not _is_library(path)
        return packages_in(file_bytes(path)) if is_read else frozenset()
    except OSError:
        return frozenset()


def _is_library(path: Path) -> bool:
    """Whether a file is a copy of a library that is known by its name."""
    try:
        with regular_file(path) as file:
            data = file.read(_HEAD)
    except OSError:
        return False
    matched = _LIBRARY.search(data)
    name = (matched[1] or matched[2]).decode(errors="replace") if matched else ""
    return standard_package(name) is not None


def _steps(start: Path, end: Path) -> tuple[str, ...]:
    """Return the folders to leave and to enter on the way from one folder to another."""
    return Path(os.path.relpath(end, start)).parts
