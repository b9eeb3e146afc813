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


Detection = Literal["mission_start", "each_visit"]
"""When the failed units of a redundant group are found, and the group is whole again."""


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
    `detected` tells how long the first failure of a redundant group stays hidden, `None` where
    the description does not say; `test_interval_s` is the time between tests [s], where it is
    tested within the mission.
    """

    name: str
    figures: tuple[FailureFigure, ...]
    quantity: int | None = 1
    redundancy: bool = False
    always_active: bool = False
    twin: TwinBinding | None = None
    source: str | None = None
    location: Location | None = None
    detected: Detection | None = None
    test_interval_s: float | None = None

    @property
    def detection(self) -> Detection:
        """How long a first failure stays hidden: until the next mission starts, if none says.

        Figures per visit alone are the published reading, and so are groups that are whole again
        at each visit.
        """
        if self.detected is not None:
            return self.detected
        published = all(figure.per is Basis.VISIT for figure in self.figures)
        return "each_visit" if published and self.test_interval_s is None else "mission_start"


@dataclass(frozen=True, slots=True)
class Hardware:
    """A hardware description; `components` in the order of the file."""

    file: str
    components: tuple[Component, ...]
    robot: str | None = None
    source: str | None = None
