"""The files from which a hardware description is read, found without reading it as such."""

from __future__ import annotations

import re
from pathlib import Path

from tracerisk.errors import HardwareError, Location

_PACKAGE = re.compile(rb"\bpackage\s+(?:<[^>]*>\s*)?(?:'((?:[^'\\\n]|\\.)+)'|(\w+))")


def source_files(path: Path) -> tuple[Path, ...]:
    """Return the file of a description, and those beside it that it may be read from, sorted.

    Of SysML v2 these are the files beside it that declare a package whose name stands in the
    text: some of them may not be read after all, none of those that are is left out.
    Raises HardwareError where a file cannot be read.
    """
    if path.suffix.lower() != ".sysml":
        return (path,)
    own = path.resolve()
    beside = {
        item: _read(item)
        for item in sorted(path.parent.glob("*.sysml"))
        if item.is_file() and item.resolve() != own
    }
    reached: list[Path] = []
    texts = [_read(path)] if beside else []
    while texts:
        text = texts.pop()
        for item, data in beside.items():
            names = (quoted or plain for quoted, plain in _PACKAGE.findall(data))
            if item not in reached and any(name in text for name in names):
                reached.append(item)
                texts.append(data)
    return (path, *sorted(reached))


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return b""
    except OSError as cause:
        raise HardwareError(f"cannot be read: {cause.strerror}", Location(str(path))) from cause
