"""What is declared of a recording, and what the effort of its joint states means by it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tracerisk.errors import SettingsError, one_of
from tracerisk.twin.robots.robot_parts import Joint

_ALLOWED = ("Nm", "%", "mA:K", "A:K")


@dataclass(frozen=True, slots=True)
class EffortUnit:
    """The unit of effort, as factors to N m, or N for a sliding joint.

    A factor of `None` means per cent of the torque limit.
    """

    of_all: float | None = 1.0
    """The factor of joints that are not in `by_joint`."""
    by_joint: Mapping[str, float | None] = field(default_factory=dict)
    """The factors of single joints, by name."""
    text: str = "Nm"
    """The unit as the user wrote it, such as `mA:1.2,joint_1=mA:3.1`."""

    def factor(self, joint: Joint) -> float:
        """Return what one unit is of a joint [N m or N]."""
        value = self.by_joint.get(joint.name, self.of_all)
        return joint.torque_limit / 100.0 if value is None else value


@dataclass(frozen=True, slots=True)
class Declared:
    """What is declared of a recording."""

    effort_unit: EffortUnit | None = None
    """The unit of effort; `None` where it is not known."""
    encoder_step: float | None = None
    """The least difference of two positions [rad or m]; `None` where it is not known."""
    joint_states: str | None = None
    """The topic of joint states; `None` for the one that fits the robot."""
    commands: Path | None = None
    """A file of the probe."""
    functions: Path | None = None
    """A CSV file with the times of functions."""
    names: str | None = None
    """A topic with the names of functions."""
    controller: str = ""
    """The file of the controller; empty for what the probe says."""
    states: Collection[str] = ()
    """Qualified names of functions that are steps of the task."""
    helpers: Collection[str] = ()
    """Qualified names of functions that are none."""


def parse_effort_unit(text: str) -> EffortUnit:
    """Read `Nm`, `%`, `mA:K` or `A:K` with the torque constant K in N m per A at the joint.

    Units of single joints follow behind commas: `mA:1.2,joint_1=mA:3.1`.
    Raises SettingsError for anything else.
    """
    of_all: float | None = 1.0
    by_joint: dict[str, float | None] = {}
    has_all = False
    for part in text.split(","):
        joint, equals, unit = part.strip().rpartition("=")
        factor = _factor(unit, text)
        if equals:
            by_joint[joint.strip()] = factor
        else:
            if has_all:
                raise SettingsError(
                    f"--effort-unit: {text!r} has two units for all joints; write JOINT=UNIT"
                )
            of_all, has_all = factor, True
    return EffortUnit(of_all, by_joint, text)


def _factor(unit: str, text: str) -> float | None:
    name, colon, constant = unit.partition(":")
    if name in ("Nm", "N") and not colon:
        return 1.0
    if name == "%" and not colon:
        return None
    if name in ("mA", "A"):
        try:
            value = float(constant)
        except ValueError:
            value = math.nan
        if not colon or not math.isfinite(value) or value <= 0.0:
            raise SettingsError(
                f"--effort-unit: {text!r} lacks the torque constant; write {name}:K with K in N m "
                f"per A at the joint, the gear included: {name}:0.8"
            )
        return value / 1000.0 if name == "mA" else value
    raise SettingsError(f"--effort-unit: {text!r} is not a unit; {one_of(_ALLOWED, name)}")
