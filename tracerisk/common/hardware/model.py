"""The hardware description: which components, how they fail, where the twin sees them."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, cast

from tracerisk.common.hardware.redundancy import ALL_NEEDED, Detection, Redundancy, Repair
from tracerisk.common.hardware.units import SHEET_KINDS, DataSheet
from tracerisk.common.traced.elements import ElementKind, SensorKind
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
    "noisy",
    "no_force",
    "opens",
    "stuck",
    "lost_with_brakes",
    "lost_without_brakes",
    "link_lost",
]
"""How a unit of the twin can be made to fail; docs/faults.md says what each does."""
FAULTS: Mapping[ElementKind, tuple[FaultMode, ...]] = {
    "joint": ("dead", "jam"),
    "gripper": ("no_force", "opens", "stuck"),
    "sensor": ("offset", "frozen", "absent", "noisy"),
}
"""The faults that a unit of each kind can have."""

SHORTEST_FAULT_S, LONGEST_FAULT_S = 0.001, 3600.0
"""How long a fault that passes may last [s]."""


def fault_kind(mode: str, lasts_s: float | None) -> str:
    """Return what a fault is called: its mode, and for how long it lasts where it passes [s]."""
    return mode if lasts_s is None else f"{mode} for {lasts_s:g} s"


def mode_and_duration(kind: str) -> tuple[FaultMode, float | None]:
    """Return the mode of what `fault_kind` calls a fault, and how long it lasts [s]."""
    mode, _, lasts = kind.partition(" for ")
    return cast(FaultMode, mode), float(lasts.removesuffix(" s")) if lasts else None


POWER, CONTROL = "power", "control"
"""The units of the twin that are no element of the robot: its power supply and control unit."""


FIGURE_KEYS = ("probability", "failure_rate", "standby_rate", "weibull", *SHEET_KINDS)
"""The keys of a description that hold failure figures, in the order of the figures."""


@dataclass(frozen=True, slots=True)
class FailureFigure:
    """One term of a unit's failure probability."""

    kind: Literal["probability", "failure_rate", "weibull"]
    """`probability` of a failure per basis, constant `failure_rate` or wear-out by `weibull`."""
    value: float
    """The probability, or the rate per basis of time; for `weibull` the characteristic life in the
    time of the basis."""
    per: Basis
    """The basis: a minute or hour, a demand or a visit."""
    shape: float = 1.0
    """The exponent of wear-out, for `weibull` only; 1 is a constant rate."""
    standby: bool = False
    """Whether a figure per time counts the time in the mission when the unit is not in use,
    instead of the time in use."""
    demand: Demand | None = None
    """What a figure per demand counts; `None` for the grasps of a gripper, else the motions
    begun."""
    error_factor: float | None = None
    """The ratio p95/p50 of a lognormal, above 1; `None` where no uncertainty is given."""
    value_is: Statistic = "median"
    """Whether `value` is the median or the mean of that lognormal."""
    source: str | None = None
    """Where the figure is from; `None` for the component's source."""
    sheet: DataSheet | None = None
    """What a data sheet states, of which `value` is made; `None` where it is the value."""
    fit: float | None = field(default=None, compare=False)
    """The rate as it is stated in FIT, failures per 1e9 hours; `None` where it is not."""

    @property
    def stated(self) -> str:
        """What a data sheet states, in words: `MTBF 886000 h`, `57 FIT`; empty for the value."""
        rate = "" if self.fit is None else f"{self.fit:.10g} FIT"
        return rate if self.sheet is None else self.sheet.text(rate)

    @property
    def key(self) -> str:
        """The key of the figure in a description, one of `FIGURE_KEYS`."""
        if self.sheet is not None and self.sheet.kind is not None:
            return self.sheet.kind
        return "standby_rate" if self.standby else self.kind

    @property
    def usual_statistic(self) -> Statistic:
        """What a figure with an error factor is unless it says so: 1 / MTBF is a mean."""
        return "median" if self.sheet is None or self.sheet.kind is None else "mean"


@dataclass(frozen=True, slots=True)
class LoadLaw:
    """How load ages a unit: rate x [(1-phi) + phi (L/L0)^k], of what moves and carries."""

    reference_load: float
    """L0, the load at which the figures hold, as a fraction of the rated torque [1]."""
    wearing_share: float
    """phi, the share of failures that wear causes, from 0 to 1."""
    exponent: float = 3.0
    """k, one of `tracerisk.common.traced.elements.WEAR_EXPONENTS`."""
    reference_speed: float | None = None
    """The speed at which the figures hold, as a fraction of the rated one [1]; `None` for the mean
    speed of the mission."""
    source: str | None = None
    """Where the law is from; `None` for the component's source."""


@dataclass(frozen=True, slots=True)
class FailureMode:
    """A share of a unit's failures, which counts only while it can matter."""

    name: str
    """The name of the mode, unique in the component."""
    fraction: float
    """The share of the unit's failures, from 0 to 1."""
    when: tuple[State | Demand, ...]
    """The states whose time counts for figures per time, and the demands that count for figures
    per demand; empty where all use counts."""
    source: str | None = None
    """Where the fraction is from; `None` for the component's source."""
    fault: FaultMode | None = None
    """How the twin shows the mode; `None` where the description gives none."""
    lasts_s: float | None = None
    """For how long a failure of the mode lasts, where it is intermittent [s]; `None`: it stays."""

    @property
    def tried_as(self) -> str | None:
        """What the mode of its failures on the twin is called, with how long they last."""
        return None if self.fault is None else fault_kind(self.fault, self.lasts_s)


NOT_OPTIONAL = "only a component of the gripper, of sensors or of all joints can be optional"
"""What is wrong with a binding that is optional and may not be."""


@dataclass(frozen=True, slots=True)
class TwinBinding:
    """Where the twin sees a component; each field that is given adds elements."""

    joints: tuple[str, ...] | Literal["*"] = ()
    """The joints by name; `"*"` for all of the arm."""
    gripper: bool = False
    """Whether each gripper is a unit."""
    optional: bool = False
    """Whether the robot may lack the component; it then has as many units as the robot."""
    actuators: tuple[str, ...] = ()
    """The actuators by name, for the joints that they move."""
    sensors: tuple[str, ...] | SensorKind = ()
    """The sensors by name, or a kind for all sensors of that kind."""
    contacts: tuple[str, ...] = ()
    """The links that touch, by name."""

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
    """One hardware component, with all its units."""

    name: str
    """The name, qualified by its assemblies (`arm.joint.motor`)."""
    figures: tuple[FailureFigure, ...]
    """The terms of one unit's failure probability, which add up as independent causes; sorted by
    kind: probabilities, rates, standby, Weibull."""
    quantity: int | None = 1
    """The number of units; `None` for as many as the robot has."""
    redundancy: Redundancy = ALL_NEEDED
    """How many units must work; `detected` is resolved."""
    always_active: bool = False
    """Whether it is in use during the whole mission, without a place in the twin."""
    twin: TwinBinding | None = None
    """Where the twin sees it; `None` for a component that is always active or not bound."""
    load_law: LoadLaw | None = None
    """How load ages a unit; `None` for no effect of load."""
    modes: tuple[FailureMode, ...] = ()
    """The failure modes; empty where the description does not split its failures."""
    age_s: float = 0.0
    """The time for which the units were in use before the mission [s]."""
    source: str | None = None
    """Where its figures are from; `None` where the description names no source."""
    location: Location | None = field(default=None, compare=False)
    """The place in the description; `None` for a component that no file describes."""
    test_interval_s: float | None = None
    """The time between tests within the mission [s]; `None` for no tests."""
    exposure_error_factor: float | None = None
    """How far the use that a run shows may be off from that in the field: p95/p50 of a lognormal of
    median 1, from 1 on; `None`: not at all."""
    lot: str | None = None
    """The production lot of its units; the figures of one lot are off together. `None`: by
    themselves."""
    repair: Repair | None = None
    """How long the repair of a unit takes while other missions go on; `None`: it is replaced
    when `redundancy.detected` says."""

    def __post_init__(self) -> None:
        ordered = tuple(sorted(self.figures, key=_rank))
        object.__setattr__(self, "figures", ordered)

    @property
    def modes_by_use(self) -> tuple[FailureMode, ...]:
        """The failure modes that each count for uses of their own; empty where all count for all.

        Modes that say nothing of uses move no figure: they share out what evidence gives.
        """
        return self.modes if any(mode.when for mode in self.modes) else ()

    @property
    def is_assumed(self) -> bool:
        """Whether a figure of the component has no source: its `source` begins with `assumed`."""
        return any(map(is_assumed, self.sources()))

    @property
    def unlikely(self) -> list[str]:
        """What makes the temperatures of its figures doubtful, in words; empty where usual."""
        at = [figure.sheet.temperature for figure in self.figures if figure.sheet is not None]
        return [one.unlikely for one in at if one is not None and one.unlikely]

    @property
    def law_sources(self) -> list[str | None]:
        """The sources of its load law and of the failure modes that count for uses of their own."""
        law = [] if self.load_law is None else [self.load_law.source]
        return [*law, *(mode.source for mode in self.modes_by_use)]

    @property
    def is_uncertain(self) -> bool:
        """Whether a figure of the component, or the use that it counts, has an error factor."""
        return self.exposure_error_factor is not None or any(
            figure.error_factor is not None for figure in self.figures
        )

    def sources(self, default: str | None = None) -> tuple[str, ...]:
        """Return where its figures, load law and modes come from, each source once.

        What has none of its own has that of the component, and where that has none the `default`.
        """
        own = [*(figure.source for figure in self.figures), *self.law_sources]
        generator = (name or self.source or default for name in own or [None])
        return tuple(dict.fromkeys(name for name in generator if name))


def is_assumed(source: str) -> bool:
    """Return whether a source is none: it begins with `assumed`."""
    return source.lstrip().lower().startswith("assumed")


def _rank(figure: FailureFigure) -> int:
    return FIGURE_KEYS.index(figure.key)


def default_detection(figures: tuple[FailureFigure, ...], tested: bool) -> Detection:
    """Return how long a first failure stays hidden where the description does not say.

    Figures per visit alone are the published reading, and so are groups that are whole again
    at each visit; else a failure stays hidden until the next mission starts.
    """
    published = all(figure.per is Basis.VISIT for figure in figures)
    return "each_visit" if published and not tested else "mission_start"


@dataclass(frozen=True, slots=True)
class Hardware:
    """A hardware description.

    Two descriptions of the same are equal, whatever their files and formats.
    """

    file: str = field(compare=False)
    """The path of the description, for messages."""
    components: tuple[Component, ...]
    """The components in the order of the file."""
    robot: str | None = None
    """The robot that it describes; `None` for any robot."""
    source: str | None = None
    """The source of figures that name none; `None` where there is none."""
    warnings: tuple[str, ...] = field(default=(), compare=False)
    """What of the file was left out or is doubtful, with its places."""

    @property
    def unlikely(self) -> tuple[str, ...]:
        """The rates that a temperature changes by more than is usual, each with its place."""
        return tuple(
            f"{component.location}: {component.name}: {words}"
            for component in self.components
            for words in component.unlikely
        )
