"""The hardware descriptions that come with tracerisk, one for each robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from tracerisk.common.hardware.model import Component, Hardware
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Element
from tracerisk.errors import HardwareError, one_of

_FOLDER = Path(__file__).parent / "robots"
_SHOWN_FOLDER = "tracerisk/common/hardware/robots/"

GENERIC = "generic"
"""The description, all assumed, of an arm for which none of its own is shipped."""
ADDED = "+"
"""What stands before the gripper that an arm is given, in the name of a robot."""


def hardware_of(robot: str) -> Hardware:
    """Return the description shipped for `robot`, else the generic one."""
    return shipped_hardware(bare_arm(robot) if is_shipped(robot) else GENERIC)


def shipped_bytes(hardware: Hardware) -> bytes:
    """Return the file that a shipped description was read from."""
    return (_FOLDER / hardware.file.removeprefix(_SHOWN_FOLDER)).read_bytes()


def shipped_names() -> tuple[str, ...]:
    """Return the robots for which a description is shipped, and the generic one, sorted."""
    return tuple(sorted(entry.stem for entry in _FOLDER.glob("*.yaml")))


def is_shipped(robot: str) -> bool:
    """Return whether a description of its own is shipped for a robot."""
    return robot != GENERIC and (_FOLDER / f"{bare_arm(robot)}.yaml").is_file()


def bare_arm(robot: str) -> str:
    """Return the name of a robot without the gripper that its arm is given."""
    return robot.partition(ADDED)[0]


def shipped_hardware(robot: str) -> Hardware:
    """Return the description shipped for `robot`; raise HardwareError if there is none."""
    path = _FOLDER / f"{robot}.yaml"
    if not path.is_file():
        raise HardwareError(
            f"no hardware description is shipped for robot '{robot}'; "
            f"{one_of(shipped_names(), robot)}; name your own with --hardware FILE"
        )
    return read_hardware(path, shown=f"{_SHOWN_FOLDER}{robot}.yaml")


def fitted_to(hardware: Hardware, elements: Sequence[Element]) -> Hardware:
    """Return a shipped description as it stands for a robot with other joints than its own.

    A robot of several such arms has each component once for each arm: a motor for each joint, and
    what is always active again under a name of its own, so that redundant units replace only
    those of their arm. One with further joints has a motor for each. A user's file stays as it is.
    """
    own, places = _joints(hardware, elements)
    if own == places:
        return hardware
    arms = _arms(own, places)
    fitted = tuple(part for component in hardware.components for part in _for_arms(component, arms))
    return replace(hardware, components=fitted)


def fitting_words(hardware: Hardware, elements: Sequence[Element]) -> tuple[str, ...]:
    """Return what is assumed where a shipped description stands for a robot with other joints."""
    own, places = _joints(hardware, elements)
    if own == places:
        return ()
    arms = _arms(own, places)
    taken = (
        f"its components are taken once for each of {arms} such arms"
        if arms > 1
        else "a motor is taken for each joint, and the rest as it is"
    )
    return (
        f"hardware: {hardware.file} describes {own} joints, and the robot has {places}: {taken}; "
        "give --hardware",
    )


def _joints(hardware: Hardware, elements: Sequence[Element]) -> tuple[int, int]:
    """Return how many joints a shipped description counts, and how many the robot has.

    They are the same where the description leaves their number to the robot.
    """
    places = sum(element.kind == "joint" for element in elements)
    if places and hardware.file.startswith(_SHOWN_FOLDER):
        for component in hardware.components:
            if _has_every_joint(component) and component.quantity is not None:
                return component.quantity, places
    return places, places


def _has_every_joint(component: Component) -> bool:
    return component.twin is not None and component.twin.joints == "*"


def _arms(own: int, places: int) -> int:
    return places // own if places % own == 0 else 1


def _for_arms(component: Component, arms: int) -> Iterator[Component]:
    if _has_every_joint(component):
        yield replace(component, quantity=None)
        return
    yield component
    if component.always_active:
        for arm in range(2, arms + 1):
            yield replace(component, name=f"{component.name}_{arm}")
