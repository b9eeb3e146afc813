"""The formats of a hardware description, distinguished by the names of files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path, PurePath
from typing import Literal

from tracerisk.common.hardware.model import Hardware
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.hardware.source_files import is_sysml
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.hardware.yaml.writer import write_hardware
from tracerisk.common.text.bounded import is_folder
from tracerisk.config import Settings
from tracerisk.errors import HardwareError, Location, one_of

HardwareFormat = Literal["yaml", "sysml"]

_SUFFIXES: dict[str, HardwareFormat] = {".yaml": "yaml", ".yml": "yaml", ".sysml": "sysml"}


def format_of_name(name: str) -> HardwareFormat:
    """Return the format that a file of this name holds; raise HardwareError for another suffix.

    A folder holds SysML v2.
    """
    if is_folder(Path(name)):
        return "sysml"
    suffix = PurePath(name).suffix.lower()
    if suffix not in _SUFFIXES:
        text = f"its name ends in '{suffix}'" if suffix else "its name has no ending"
        raise HardwareError(
            f"{text}, which is not a supported format; {one_of(_SUFFIXES)}", Location(name)
        )
    return _SUFFIXES[suffix]


def read_description(
    path: Path, *, shown: str | None = None, system: str | None = None
) -> Hardware:
    """Read a hardware description: SysML v2 of a file `.sysml` or of a folder, else YAML.

    `system` names the part of a description in SysML that is the system.
    Raises HardwareError with file, line and column where it is malformed.
    """
    hardware = _read(path, shown, system)
    return replace(hardware, warnings=(*hardware.warnings, *hardware.unlikely))


def _read(path: Path, shown: str | None, system: str | None) -> Hardware:
    if is_sysml(path):
        # Imported here: YAML is read without the parser of SysML.
        from tracerisk.common.hardware.sysml.sysml_reader import read_sysml

        return read_sysml(path, shown=shown, system=system)
    if system is not None:
        raise HardwareError(
            f"is YAML, which describes one system; leave out the system '{system}'",
            Location(shown or str(path)),
        )
    return read_hardware(path, shown=shown)


def load_hardware(settings: Settings, robot: str) -> Hardware:
    """Return the hardware description of the settings, else the one shipped for the robot.

    A robot for which none is shipped has the generic one, whose figures are all assumed.
    A folder, and one whose name ends in `.sysml`, is read as SysML v2, any other as YAML.
    Raises HardwareError when it is malformed, or is that of another robot.
    """
    if settings.hardware is None:
        if settings.system is not None:
            raise HardwareError(
                f"the system '{settings.system}' is a part of a description in SysML; give the "
                "description as well, by --hardware or the setting hardware"
            )
        return hardware_of(robot)
    hardware = read_description(Path(settings.hardware), system=settings.system)
    if hardware.robot is not None and robot not in ("", hardware.robot):
        raise HardwareError(
            f"describes robot '{hardware.robot}', but the controller drives '{robot}'; give the "
            "description of that robot, or leave 'robot' out of one that fits several; if the "
            f"controller drives '{hardware.robot}', set --robot or the setting robot",
            Location(hardware.file),
        )
    return hardware


def write_description(hardware: Hardware, format_: HardwareFormat) -> str:
    """Return the description as text; reading it gives an equal one."""
    if format_ == "sysml":
        from tracerisk.common.hardware.sysml.writer import write_sysml

        return write_sysml(hardware)
    return write_hardware(hardware)
