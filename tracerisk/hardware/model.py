"""The hardware description: which components, how they fail, where the twin sees them."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Literal

from tracerisk.errors import Location


class Basis(enum.Enum):
    """What a failure probability is counted per."""

    VISIT = "visit"
    DEMAND = "demand"
    MINUTE = "minute"
    HOUR = "hour"

    @property
    def seconds(self) -> float | None:
        """The time that the basis spans [s]; `None` where it counts events."""
        return {Basis.MINUTE: 60.0, Basis.HOUR: 3600.0}.get(self)


@dataclass(frozen=True, slots=True)
class FailureFigure:
    """A failure probability per basis, or a constant failure rate per basis of time."""

    kind: Literal["probability", "failure_rate"]
    value: float
    per: Basis


@dataclass(frozen=True, slots=True)
class TwinBinding:
    """Where the twin sees a component: joints by name (`"*"` for each of the arm), grippers.

    An `optional` one stands for each gripper that the robot has, be it none.
    """

    joints: tuple[str, ...] | Literal["*"] = ()
    gripper: bool = False
    optional: bool = False


@dataclass(frozen=True, slots=True)
class Component:
    """One hardware component: `quantity` equal units, all needed unless `redundancy`.

    `figures` are the terms of one unit's failure probability; they add up as independent causes.
    `quantity` is `None` where the description leaves it to the number of joints that the robot has.
    """

    name: str
    figures: tuple[FailureFigure, ...]
    quantity: int | None = 1
    redundancy: bool = False
    always_active: bool = False
    twin: TwinBinding | None = None
    source: str | None = None
    location: Location | None = None


@dataclass(frozen=True, slots=True)
class Hardware:
    """A hardware description; `components` in the order of the file."""

    file: str
    components: tuple[Component, ...]
    robot: str | None = None
    source: str | None = None
