"""The formats of a hardware description, distinguished by the names of files."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import Literal

from tracerisk.errors import HardwareError, Location, one_of
from tracerisk.hardware.model import Hardware

HardwareFormat = Literal["yaml", "sysml"]

_SUFFIXES: dict[str, HardwareFormat] = {".yaml": "yaml", ".yml": "yaml", ".sysml": "sysml"}


def format_of_name(name: str) -> HardwareFormat:
    """Return the format that a file of this name holds; raise HardwareError for another suffix."""
    suffix = PurePath(name).suffix.lower()
    if suffix not in _SUFFIXES:
        found = f"its name ends in '{suffix}'" if suffix else "its name has no ending"
        raise HardwareError(f"{found}, which is not a format; {one_of(_SUFFIXES)}", Location(name))
    return _SUFFIXES[suffix]


def read_description(path: Path, *, shown: str | None = None) -> Hardware:
    """Read a hardware description: SysML v2 where the name ends in `.sysml`, else YAML.

    Raises HardwareError with file, line and column where it is malformed.
    """
    if path.suffix.lower() == ".sysml":
        # Imported here: YAML is read without the parser of SysML.
        from tracerisk.hardware.sysml.reader import read_sysml

        return read_sysml(path, shown=shown)
    from tracerisk.hardware.yaml.reader import read_hardware

    return read_hardware(path, shown=shown)


def write_description(hardware: Hardware, format_: HardwareFormat) -> str:
    """Return the description as text; reading it gives an equal one."""
    if format_ == "sysml":
        from tracerisk.hardware.sysml.writer import write_sysml

        return write_sysml(hardware)
    from tracerisk.hardware.yaml.writer import write_hardware

    return write_hardware(hardware)
