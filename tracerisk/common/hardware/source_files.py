"""The files from which a hardware description is read, found without reading it as such."""

from __future__ import annotations

import os
import re
from pathlib import Path, PurePath

from tracerisk.common.text.bounded import file_bytes, in_folder, is_folder
from tracerisk.errors import HardwareError, Location

_TOP_KEY = re.compile(rb"^(\w[\w-]*)[ \t]*:", re.MULTILINE)
_PACKAGE = re.compile(rb"\bpackage\s+(?:<[^>]*>\s*)?(?:'((?:[^'\\\n]|\\.)+)'|(\w+))")


TOP_KEYS = frozenset({"components", "robot", "source"})
"""The keys at the top of a description in YAML."""


MAX_FILES = 5_000
"""How many files a folder may hold."""


def is_sysml(path: Path) -> bool:
    """Whether a description is SysML v2: a file by its name, or a folder."""
    return has_sysml_name(path.name) or is_folder(path)


def has_sysml_name(name: str) -> bool:
    """Whether a file of this name or path holds SysML v2; capitals or not make no difference."""
    return PurePath(name).suffix.lower() == ".sysml"


def sysml_files(path: Path) -> tuple[Path, ...]:
    """Return a file itself, or the SysML files below a folder, sorted.

    What is hidden, or no file, is left out.
    Raises HardwareError for a folder with none, or with more than `MAX_FILES`.
    """
    if not is_folder(path):
        return (path,)
    files: list[Path] = []
    for folder, below, names in os.walk(path):
        below[:] = sorted(name for name in below if not name.startswith("."))
        files += [
            file
            for file in (Path(folder, name) for name in names if not name.startswith("."))
            if has_sysml_name(file.name) and file.is_file()
        ]
        if len(files) > MAX_FILES:
            raise HardwareError(
                f"holds more than {MAX_FILES} .sysml files; give the folder of one model",
                Location(str(path)),
            )
    if not files:
        raise HardwareError(
            "is a folder without a .sysml file; give that of a model", Location(str(path))
        )
    return tuple(sorted(files))


def sysml_files_in(folder: Path) -> tuple[Path, ...]:
    """Return the SysML files right in a folder, sorted; none of one that cannot be read."""
    return tuple(path for path in in_folder(folder) if has_sysml_name(path.name))


def source_files(path: Path) -> tuple[Path, ...]:
    """Return the file of a description, and those beside it that it may be read from, sorted.

    Of a folder these are all its files; of a file in SysML v2 those beside it that declare a
    package whose name stands in the text: some of them may not be read after all, none of those
    that are is left out.
    Raises HardwareError where a file cannot be read.
    """
    if is_folder(path):
        return sysml_files(path)
    if not is_sysml(path):
        return (path,)
    own = path.resolve()
    beside = {
        item: _read(item)
        for item in sysml_files_in(path.parent)
        if item.is_file() and item.resolve() != own
    }
    reached: list[Path] = []
    texts = [_read(path)] if beside else []
    while texts:
        text = texts.pop()
        for item, data in beside.items():
            if item not in reached and any(name.encode() in text for name in packages_in(data)):
                reached.append(item)
                texts.append(data)
    return (path, *sorted(reached))


def packages_in(data: bytes) -> frozenset[str]:
    """Return the names of the packages that a file in SysML v2 declares, at the least."""
    names = (quoted or plain for quoted, plain in _PACKAGE.findall(data))
    return frozenset(name.decode(errors="replace") for name in names)


def _read(path: Path) -> bytes:
    try:
        return file_bytes(path)
    except FileNotFoundError:
        return b""
    except OSError as cause:
        raise HardwareError(f"cannot be read: {cause.strerror}", Location(str(path))) from cause


def describes_hardware(data: bytes) -> bool:
    """Return whether a YAML file is a description of hardware, by its keys at the top.

    Failure data decide no run: whoever searches files for what does leaves them out.
    """
    keys = {key.decode(errors="replace") for key in _TOP_KEY.findall(data)}
    return "components" in keys and keys <= TOP_KEYS
