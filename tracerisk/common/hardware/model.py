"""The hardware description: which components, how they fail, where the twin sees them."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.common.hardware.redundancy import ALL_NEEDED, Detection, Redundancy
from tracerisk.errors import Location
from tracerisk.trace import ElementKind, SensorKind


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


State = Literal["moving", "holding", "grasping"]
"""A state of use that lasts, and so is exposure."""
Demand = Literal["start", "grasp", "release"]
"""A use that is counted: a motion begun, a grasp closed, a grasp opened."""
Statistic = Literal["median", "mean"]
"""What a figure with an error factor is, of what it may be."""
FaultMode = Literal[
    "dead",
    "jam",
    "offset",
    "frozen",
    "absent",
    "no_force",
    "opens",
    "stuck",
    "lost_with_brakes",
    "lost_without_brakes",
]
"""How a unit of the twin can be made to fail; docs/faults.md says what each does."""
FAULTS: Mapping[ElementKind, tuple[FaultMode, ...]] = {
    "joint": ("dead", "jam"),
    "gripper": ("no_force", "opens", "stuck"),
    "sensor": ("offset", "frozen", "absent"),
}
"""The faults that a unit of each kind can have."""
POWER, CONTROL = "power", "control"
"""The units of the twin that are no element of the robot: its power supply and control unit."""


@dataclass(frozen=True, slots=True)
class FailureFigure:
    """One term of a unit's failure probability.

    `probability`: of a failure per basis. `failure_rate`: constant, per basis of time.
    `weibull`: `value` is the characteristic life, in the time of the basis, and `shape` the
    exponent of wear-out (1 is a constant rate); the component's age says where on it the unit is.
    A figure per time counts the time in use; one that is `standby` the time of the mission in
    which the unit is not in use. A figure per demand counts `demand`, `None` for what is usual:
    the grasps of a gripper, else the motions begun.
    `error_factor` is p95/p50 of a lognormal, whose median is the value unless `value_is` mean.
    """

    kind: Literal["probability", "failure_rate", "weibull"]
    value: float
    per: Basis
    shape: float = 1.0
    standby: bool = False
    demand: Demand | None = None
    error_factor: float | None = None
    value_is: Statistic = "median"
    source: str | None = None


@dataclass(frozen=True, slots=True)
class LoadLaw:
    """How load ages a unit: rate x [(1-phi) + phi (L/L0)^k], of what moves and carries.

    `wearing_share` is phi, `exponent` k (one of `tracerisk.trace.WEAR_EXPONENTS`).
    `reference_load` is L0 and `reference_speed` the speed at which the figures hold, as fractions
    of the rated torque and speed; without a speed it is the mean speed of the mission.
    """

    reference_load: float
    wearing_share: float
    exponent: float = 3.0
    reference_speed: float | None = None
    source: str | None = None


@dataclass(frozen=True, slots=True)
class FailureMode:
    """A share of a unit's failures, which counts only while it can matter.

    `when` are the states whose time counts for figures per time, and the demands that count for
    figures per demand; empty where all use counts, as without modes. `fault` is how the twin shows
    the mode, `None` where it does not say.
    """

    name: str
    fraction: float
    when: tuple[State | Demand, ...]
    source: str | None = None
    fault: FaultMode | None = None


NOT_OPTIONAL = "only a component of the gripper, of sensors or of all joints can be optional"
"""What is wrong with a binding that is optional and may not be."""


@dataclass(frozen=True, slots=True)
class TwinBinding:
    """Where the twin sees a component; each field that is given adds elements.

    `joints` by name, `"*"` for each of the arm; `actuators` by name, for the joints that they
    move; `gripper` for the grippers; `sensors` by name, or a kind for all of that kind;
    `contacts` by the link that touches.
    An `optional` one stands for each that the robot has, be it none.
    """

    joints: tuple[str, ...] | Literal["*"] = ()
    gripper: bool = False
    optional: bool = False
    actuators: tuple[str, ...] = ()
    sensors: tuple[str, ...] | SensorKind = ()
    contacts: tuple[str, ...] = ()

    @property
    def can_be_optional(self) -> bool:
        """Whether it names what a robot may lack: a gripper, sensors, or joints at all."""
        return self.gripper or bool(self.sensors) or self.joints == "*"

    @property
    def moves(self) -> bool:
        """Whether what it sees can move and carry."""
        return self.gripper or bool(self.joints) or bool(self.actuators)

    @property
    def named_units(self) -> int | None:
        """How many elements it names, one a gripper; `None` where only the robot gives it."""
        if self.joints == "*" or isinstance(self.sensors, str):
            return None
        named = (self.joints, self.actuators, self.sensors, self.contacts)
        return sum(map(len, named)) + int(self.gripper)


@dataclass(frozen=True, slots=True)
class Component:
    """One hardware component: `quantity` units, all needed unless `redundancy`.

    `name` is qualified by its assemblies (`arm.joint.motor`).
    `figures` are the terms of one unit's failure probability; they add up as independent causes.
    They are kept by kind, for their order says nothing: probabilities, rates, standby, Weibull.
    `quantity` is `None` where the description leaves it to what the robot has.
    `redundancy.detected` is resolved: the published reading where all figures are per visit.
    `test_interval_s` is the time between tests [s], of a group that is tested within the mission.
    `age_s` is the time for which the units were in use before the mission [s].
    """

    name: str
    figures: tuple[FailureFigure, ...]
    quantity: int | None = 1
    redundancy: Redundancy = ALL_NEEDED
    always_active: bool = False
    twin: TwinBinding | None = None
    load_law: LoadLaw | None = None
    modes: tuple[FailureMode, ...] = ()
    age_s: float = 0.0
    source: str | None = None
    location: Location | None = field(default=None, compare=False)
    test_interval_s: float | None = None

    def __post_init__(self) -> None:
        ordered = tuple(sorted(self.figures, key=_rank))
        object.__setattr__(self, "figures", ordered)

    @property
    def modes_by_use(self) -> tuple[FailureMode, ...]:
        """The failure modes that each count for uses of their own; empty where all count for all.

        Modes that say nothing of uses move no figure: they share out what evidence gives.
        """
        return self.modes if any(each.when for each in self.modes) else ()

    @property
    def is_assumed(self) -> bool:
        """Whether a figure of the component has no source: its `source` begins with `assumed`."""
        return any(map(is_assumed, self.sources()))

    @property
    def law_sources(self) -> list[str | None]:
        """The sources of its load law and of the failure modes that count for uses of their own."""
        law = [] if self.load_law is None else [self.load_law.source]
        return [*law, *(each.source for each in self.modes_by_use)]

    def sources(self, default: str | None = None) -> tuple[str, ...]:
        """Return where its figures, load law and modes come from, each source once.

        What has none of its own has that of the component, and where that has none the `default`.
        """
        own = [*(each.source for each in self.figures), *self.law_sources]
        found = (each or self.source or default for each in own or [None])
        return tuple(dict.fromkeys(each for each in found if each))


def is_assumed(source: str) -> bool:
    """Return whether a source is none: it begins with `assumed`."""
    return source.lstrip().lower().startswith("assumed")


_KIND_ORDER = {"probability": 0, "failure_rate": 1, "weibull": 3}


def _rank(figure: FailureFigure) -> int:
    return 2 if figure.standby else _KIND_ORDER[figure.kind]


def default_detection(figures: tuple[FailureFigure, ...], tested: bool) -> Detection:
    """Return how long a first failure stays hidden where the description does not say.

    Figures per visit alone are the published reading, and so are groups that are whole again
    at each visit; else a failure stays hidden until the next mission starts.
    """
    published = all(figure.per is Basis.VISIT for figure in figures)
    return "each_visit" if published and not tested else "mission_start"


@dataclass(frozen=True, slots=True)
class Hardware:
    """A hardware description; `components` in the order of the file.

    Two descriptions of the same are equal, whatever their files and formats.
    `warnings` list, with their places, what of the file was left out.
    """

    file: str = field(compare=False)
    components: tuple[Component, ...]
    robot: str | None = None
    source: str | None = None
    warnings: tuple[str, ...] = field(default=(), compare=False)
