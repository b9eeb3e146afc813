"""Read a SysML v2 file, and of the files beside it those whose packages it names."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.common.hardware.sysml.language.name_resolution import Found, Symbol
from tracerisk.common.hardware.sysml.language.parsing import parse
from tracerisk.common.hardware.sysml.language.standard_names import standard_package
from tracerisk.common.hardware.sysml.language.syntax import Element, SourceText
from tracerisk.errors import HardwareError, Location

MAX_BYTES = 16 * 1024 * 1024


def read_source(path: Path, shown: str) -> SourceText:
    """Return the text of a file.

    Raises HardwareError where it is absent, is not UTF-8, or is larger than 16 MB.
    """
    try:
        with path.open("rb") as file:
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
    """A file and those beside it, read when a name leads there.

    `files` are the tops of the files that were read, the first one first.
    """

    def __init__(self, path: Path, shown: str) -> None:
        self._path = path
        self._shown = shown
        self._beside: dict[str, Found | None] = {}
        self._tops: dict[Path, Symbol] = {}
        self.main = self._read(path, shown)

    @property
    def files(self) -> tuple[Symbol, ...]:
        """The tops of the files that were read so far."""
        return tuple(self._tops.values())

    def _read(self, path: Path, shown: str) -> Symbol:
        source = read_source(path, shown)
        top = Symbol(parse(source), None, source, self.find_package)
        self._tops[path] = top
        return top

    def find_package(self, name: str, asked_at: Location) -> Found | None:
        """Return the library package, or the element at the top of a file beside, of a name.

        Raises HardwareError where several files beside declare it.
        """
        if name not in self._beside:
            self._beside[name] = standard_package(name) or self._find_beside(name, asked_at)
        return self._beside[name]

    def _find_beside(self, name: str, asked_at: Location) -> Symbol | None:
        declares = re.compile(
            rb"\bpackage\s+(?:<[^>]*>\s*)?(?:%b\b|'%b')"
            % (re.escape(name.encode()), re.escape(name.encode()))
        )
        pairs: list[tuple[str, Symbol]] = []
        for path in sorted(self._path.parent.glob("*.sysml")):
            if path == self._path or not path.is_file() or path.stat().st_size > MAX_BYTES:
                continue
            top = self._tops.get(path)
            if top is None:
                try:
                    data = path.read_bytes()
                except OSError:
                    continue
                if not declares.search(data):
                    continue
                top = self._read(path, str(Path(self._shown).with_name(path.name)))
            hit = top.own(name)
            if hit is not None:
                pairs.append((path.name, hit))
        if len(pairs) > 1:
            files = " and ".join(file for file, _ in pairs)
            raise HardwareError(
                f"package '{name}' is declared by {files} beside this file; keep one of them",
                asked_at,
            )
        return pairs[0][1] if pairs else None


def is_part(symbol: Symbol) -> bool:
    """Whether a symbol is a usage of a part or an item."""
    node = symbol.node
    return isinstance(node, Element) and not node.is_definition and node.kind in ("part", "item")
