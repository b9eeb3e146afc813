"""A fault as data: which unit fails, in which mode, at which instant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast, get_args

from tracerisk.common.hardware.model import (
    CONTROL,
    FAULTS,
    LONGEST_FAULT_S,
    POWER,
    SHORTEST_FAULT_S,
    FaultMode,
    mode_and_duration,
)
from tracerisk.errors import InputError, one_of

if TYPE_CHECKING:
    from tracerisk.twin.robots.robot import Robot

_LATEST_S = 1e6
_SYNTAX = (
    "expected UNIT:MODE@SECONDS, such as panda_joint4:dead@3.5, with ',for=SECONDS' where it passes"
)


@dataclass(frozen=True, slots=True)
class Fault:
    """A unit that fails at an instant of simulated time, for good or for some time."""

    unit: str
    """A joint (its motor), a gripper or a sensor by its name, or `power` or `control`."""
    mode: FaultMode
    """How the unit fails; `modes_of` lists the modes of each unit."""
    time_s: float
    """The instant of the failure, in simulated time [s]."""
    lasts_s: float | None = None
    """How long it lasts, where it is intermittent [s]; `None`: the unit stays failed."""

    def __str__(self) -> str:
        passes = "" if self.lasts_s is None else f",for={self.lasts_s:g}"
        return f"{self.unit}:{self.mode}@{self.time_s:g}{passes}"

    @property
    def words(self) -> str:
        """The fault in words: `panda_joint4 dead at 3.500 s`."""
        passes = "" if self.lasts_s is None else f" for {self.lasts_s:g} s"
        return f"{self.unit} {self.mode.replace('_', ' ')} at {self.time_s:.3f} s{passes}"


def fault_named(unit: str, kind: str, time_s: float) -> Fault:
    """Return a fault of what `fault_kind` calls it."""
    mode, lasts_s = mode_and_duration(kind)
    return Fault(unit, mode, time_s, lasts_s)


def parse_fault(text: str) -> Fault:
    """Read UNIT:MODE@SECONDS; raise InputError where the text is not that."""
    rest, at, when = text.rpartition("@")
    when, comma, passes = when.partition(",")
    unit, colon, mode = rest.rpartition(":")
    if not (at and colon and unit):
        raise InputError(f"fault '{text}': {_SYNTAX}")
    if mode not in get_args(FaultMode):
        raise InputError(f"fault '{text}': unknown mode '{mode}'; {one_of(get_args(FaultMode))}")
    time_s = _number(when)
    if not 0.0 <= time_s <= _LATEST_S:
        raise InputError(
            f"fault '{text}': '{when}' is not a time in seconds from 0 to {_LATEST_S:g}; {_SYNTAX}"
        )
    if not comma:
        return Fault(unit, cast(FaultMode, mode), time_s)
    lasts_s = _number(passes.removeprefix("for=")) if passes.startswith("for=") else math.nan
    if not SHORTEST_FAULT_S <= lasts_s <= LONGEST_FAULT_S:
        raise InputError(
            f"fault '{text}': '{passes}' is not 'for=SECONDS', a time from {SHORTEST_FAULT_S:g} to "
            f"{LONGEST_FAULT_S:g}; {_SYNTAX}"
        )
    return Fault(unit, cast(FaultMode, mode), time_s, lasts_s)


def _number(text: str) -> float:
    """Return the number that a text is; not a number where it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def modes_of(robot: Robot) -> Mapping[str, tuple[FaultMode, ...]]:
    """Return every unit of a robot that can fail, with its modes, in the robot's order.

    Cameras are left out: the twin takes no pictures.
    """
    modes: dict[str, tuple[FaultMode, ...]] = {
        joint.name: FAULTS["joint"] for joint in robot.arm_joints
    }
    modes |= {gripper.name: FAULTS["gripper"] for gripper in robot.grippers}
    modes |= {sensor.name: FAULTS["sensor"] for sensor in robot.sensors if sensor.kind != "camera"}
    modes.setdefault(POWER, ("lost_with_brakes", "lost_without_brakes"))
    modes.setdefault(CONTROL, ("frozen", "link_lost"))
    return modes


def check_faults(
    faults: Sequence[Fault], robot: Robot, *, before_s: float | None = None
) -> tuple[Fault, ...]:
    """Return the faults in the order of their instants.

    Raises InputError for a unit or mode that the robot does not have, for an instant after
    `before_s` [s], and for a unit that fails twice.
    """
    modes = modes_of(robot)
    for fault in faults:
        if fault.unit not in modes:
            raise InputError(
                f"fault '{fault}': robot '{robot.name}' has no unit '{fault.unit}' that can fail; "
                f"{one_of(modes, fault.unit)}"
            )
        if fault.mode not in modes[fault.unit]:
            raise InputError(
                f"fault '{fault}': unit '{fault.unit}' of robot '{robot.name}' has no mode "
                f"'{fault.mode}'; {one_of(modes[fault.unit], fault.mode)}"
            )
        if before_s is not None and not fault.time_s < before_s:
            raise InputError(
                f"fault '{fault}': the run without a fault ends at {before_s:.3f} s; "
                "give an earlier instant"
            )
    units = [fault.unit for fault in faults]
    for index, unit in enumerate(units):
        if unit in units[:index]:
            raise InputError(f"unit '{unit}' fails twice; give it one fault")
    return tuple(sorted(faults, key=lambda item: item.time_s))
