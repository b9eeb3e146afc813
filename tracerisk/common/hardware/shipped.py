"""The hardware descriptions that come with tracerisk, one for each robot."""

from __future__ import annotations

from pathlib import Path

from tracerisk.common.hardware.model import Hardware
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.errors import HardwareError, one_of

_FOLDER = Path(__file__).parent / "robots"


GENERIC = "generic"
"""The description, all assumed, of an arm for which none of its own is shipped."""


def hardware_of(robot: str) -> Hardware:
    """Return the description shipped for `robot`, else the generic one."""
    return shipped_hardware(robot if is_shipped(robot) else GENERIC)


def shipped_names() -> tuple[str, ...]:
    """Return the robots for which a description is shipped, and the generic one, sorted."""
    return tuple(sorted(entry.stem for entry in _FOLDER.glob("*.yaml")))


def is_shipped(robot: str) -> bool:
    """Return whether a description of its own is shipped for a robot."""
    return robot != GENERIC and (_FOLDER / f"{robot}.yaml").is_file()


def shipped_hardware(robot: str) -> Hardware:
    """Return the description shipped for `robot`; raise HardwareError if there is none."""
    path = _FOLDER / f"{robot}.yaml"
    if not path.is_file():
        raise HardwareError(
            f"no hardware description is shipped for robot '{robot}'; "
            f"{one_of(shipped_names(), robot)}; name your own with --hardware FILE"
        )
    return read_hardware(path, shown=f"tracerisk/common/hardware/robots/{robot}.yaml")
