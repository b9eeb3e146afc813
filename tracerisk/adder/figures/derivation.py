"""Where the figures of one function's block come from, step by step: the steps as data."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tracerisk.adder.quantify.probability import Counted
from tracerisk.common.hardware.model import Demand, FailureFigure, LoadLaw, State
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.config import ActiveMode


@dataclass(frozen=True, slots=True)
class VisitOfFunction:
    """One visit of the function."""

    number: int
    """The number of the visit in the trace, from 1."""
    weight: int
    """How often it comes in a mission, relative to the function's other visits; above 1 only where
    the function is visited before a cycle and in it."""
    start_s: float
    """When the visit began, in simulated time [s]."""
    duration_s: float | None
    """The duration [s]; `None` where unknown."""


@dataclass(frozen=True, slots=True)
class LoadOfUnit:
    """What the load law needs of one unit in the function's visits; tuples are (n_visits,)."""

    reference_speed: float
    """The law's reference speed, or the unit's own mean over the mission, as a fraction of the
    rated speed [1]."""
    wear_s: tuple[float, ...]
    """The integral of |v| L^k over the moving time [s]."""
    travel_s: tuple[float, ...]
    """The integral of |v| over the moving time [s]."""
    wearing_s: tuple[float, ...]
    """The time at reference load and speed that wears as much [s]."""

    def mean_load(self, exponent: float) -> float:
        """Return the load at which all the travel would wear as much: (wear/travel)^(1/k)."""
        travel = math.fsum(self.travel_s)
        return (math.fsum(self.wear_s) / travel) ** (1.0 / exponent) if travel > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class TermOfUnit:
    """The value of one term for one unit, in each of the function's visits; tuples are (n_visits,).

    hazards[v] = rate x share x counted[v] x ends[v].
    """

    rate: float
    """The hazard per second, demand or visit."""
    amounts: tuple[float, ...]
    """What the term counts: seconds, demands or visits."""
    counted: tuple[float, ...]
    """The amounts after the load law has weighted them; the amounts themselves without one."""
    hazards: tuple[float, ...]
    """The hazard of the term in each visit [1]."""
    load: LoadOfUnit | None = None
    """What the load law needs; `None` without a load law."""
    ends: tuple[float, ...] = ()
    """The share of the hazard that ends the mission; empty where no evidence gives it."""


@dataclass(frozen=True, slots=True)
class TermDerivation:
    """One summand of the hazard: a figure, or the share of it that is one failure mode."""

    figure: FailureFigure
    """The figure in the hardware description."""
    counts: Counted
    """What the term counts."""
    share: float
    """The share of the figure that is the mode, from 0 to 1; 1 without a mode."""
    mode: str | None
    """The name of the failure mode; `None` where the figure counts as a whole."""
    states: tuple[State, ...] | None
    """The states whose time counts; `None` for all time in use."""
    demands: tuple[Demand, ...]
    """The demands that count; empty for a term that counts none."""
    units: tuple[TermOfUnit, ...]
    """The value for each unit, in the order of the component's units."""


@dataclass(frozen=True, slots=True)
class UnitDerivation:
    """One unit, or several that share an element."""

    element: str | None
    """The element in which the twin sees it; `None` for a component that is always active."""
    count: int
    """The number of units that share the element."""
    in_use_s: float
    """The time in use over the mission, as the load law counts it; for wear-out only [s]."""
    hazards: tuple[float, ...]
    """The hazard in each visit [1], (n_visits,)."""
    probabilities: tuple[float, ...]
    """The failure probability in each visit, (n_visits,)."""


@dataclass(frozen=True, slots=True)
class HiddenGroup:
    """A group of unlike units whose failures stay hidden until the mission ends.

    A group of units that each fail with `like` fails with the mean hazard of one mission between
    tests. The function carries `share` of the hazard: 1 - p = (1 - like)^(share / times).
    """

    units: tuple[float, ...]
    """The failure probability of each unit between two tests, (quantity,)."""
    group: float | None
    """The failure probability of the group between two tests; `None` where a common cause or
    spares are in it."""
    like: float
    """The failure probability that each unit would have if all were alike and the group failed as
    often."""
    share: float
    """The share of the hazard over a mission that the function has, from 0 to 1."""
    times: int
    """The number of visits of the function in a mission."""
    missions: float = 1.0
    """The number of missions between two tests."""
    repair: float | None = None
    """The time of a mission over the mean time of a repair; `None` without repair."""
    in_mission: bool = False
    """Whether repair goes on within missions."""
    beta: float = 0.0
    """The fraction of a unit's failures that hit all at once."""
    apart: float | None = None
    """The failure probability of the group between two tests by its units' own failures, those
    beside a common cause; with repair, the share of missions that it fails in the long run;
    `None` where there is no repair and spares are in it."""
    common: float = 0.0
    """The hazard of the common cause over one mission [1]."""
    hazard: float = 0.0
    """The hazard of the group in the mean mission [1]: -ln(1 - apart) / missions + common."""


@dataclass(frozen=True, slots=True)
class GroupDerivation:
    """How the units' figures become the block's one value, before rounding.

    The value is the one of a mean hazard, of a hidden group, or of a group renewed at each visit.
    """

    redundancy: Redundancy
    """How many units must work."""
    visits: int
    """The number of visits, each as often as its weight says."""
    quantity: int
    """The number of units."""
    hazard: float
    """The hazard summed over all units and visits [1]."""
    is_mean: bool
    """Whether the value is 1 - exp(-mean hazard), as for units that are each needed or alike."""
    value: float
    """The failure probability of one unit in one visit."""
    hidden: HiddenGroup | None = None
    """The group whose failures stay hidden; `None` for another kind."""
    renewed: tuple[float, ...] = ()
    """The failure probability of a renewed group in each visit, (n_visits,); empty for another
    kind, and where spares or a common cause make it more than a plain K-out-of-N group."""


@dataclass(frozen=True, slots=True)
class BlockValue:
    """What the block holds for the component."""

    text: str
    """The probability in the block."""
    computed: str
    """What the tool computes now, as text."""
    is_pinned: bool = False
    """Whether a user set the value."""
    is_omitted: bool = False
    """Whether a user omitted the component."""
    is_kept: bool = False
    """Whether an earlier computed text stays, because the new value is within its noise."""
    reason: str | None = None
    """The user's reason; `None` where not given."""


@dataclass(frozen=True, slots=True)
class ComponentDerivation:
    """One component of the function."""

    name: str
    """The name of the component."""
    redundancy: str
    """The redundancy as the block has it, as text."""
    always_active: bool
    """Whether it is active during the whole mission."""
    source: str | None
    """Where its figures are from; `None` where the description names no source."""
    load_law: LoadLaw | None
    """How load ages a unit; `None` for no effect of load."""
    age_s: float
    """The time in use before the mission [s]."""
    terms: tuple[TermDerivation, ...]
    """The summands of the hazard."""
    units: tuple[UnitDerivation, ...]
    """The units, one for all that share an element."""
    group: GroupDerivation
    """How the units become the one value."""
    block: BlockValue | None
    """What the block holds; `None` where it lacks the component."""


@dataclass(frozen=True, slots=True)
class FunctionDerivation:
    """Everything behind one function's block, in the order of the block."""

    function: str
    """The name of the function in the model."""
    file: str
    """The path of its source, from the controller's root."""
    active: ActiveMode
    """Which states count as active."""
    times: int
    """How often a mission visits the function."""
    visits: tuple[VisitOfFunction, ...]
    """The visits in the trace that count."""
    components: tuple[ComponentDerivation, ...]
    """The components of which something is computed."""
    by_hand: tuple[str, ...] = ()
    """The names of components that a user added to the block, without computed values."""
