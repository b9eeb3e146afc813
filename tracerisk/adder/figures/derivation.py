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
    """One visit, by its number in the trace, from 1; times in [s], `None` where unknown.

    `weight` is how often it comes in a mission, relative to the function's other visits: 1 but
    where the function is visited before a cycle and in it.
    """

    number: int
    weight: int
    start_s: float
    duration_s: float | None


@dataclass(frozen=True, slots=True)
class LoadOfUnit:
    """What the load law needs of one unit in the function's visits.

    `wear_s` is for each visit the integral of |v| L^k over the moving time, `travel_s` that of
    |v| [s]; `wearing_s` the time at reference load and speed that wears as much [s].
    `reference_speed` is that of the law, or the unit's own mean over the mission.
    """

    reference_speed: float
    wear_s: tuple[float, ...]
    travel_s: tuple[float, ...]
    wearing_s: tuple[float, ...]

    def mean_load(self, exponent: float) -> float:
        """Return the load at which all the travel would wear as much: (wear/travel)^(1/k)."""
        travel = math.fsum(self.travel_s)
        return (math.fsum(self.wear_s) / travel) ** (1.0 / exponent) if travel > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class TermOfUnit:
    """What one term comes to for one unit, in each of the function's visits.

    `rate` is the hazard per second, demand or visit; `amounts` are what the term counts, and
    `counted` the same by load. hazards[v] = rate x share x counted[v] x ends[v], of which `ends`
    is the share that ends the mission; empty where no evidence gives it.
    """

    rate: float
    amounts: tuple[float, ...]
    counted: tuple[float, ...]
    hazards: tuple[float, ...]
    load: LoadOfUnit | None = None
    ends: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class TermDerivation:
    """One summand of the hazard: a figure, or the share of it that is one failure mode.

    `units` are in the order of the component's units.
    """

    figure: FailureFigure
    counts: Counted
    share: float
    mode: str | None
    states: tuple[State, ...] | None
    demands: tuple[Demand, ...]
    units: tuple[TermOfUnit, ...]


@dataclass(frozen=True, slots=True)
class UnitDerivation:
    """One unit, or `count` that share an element: hazard and probability in each visit.

    `in_use_s` is the time in use over the mission, as the load law counts it; of what ages [s].
    """

    element: str | None
    count: int
    in_use_s: float
    hazards: tuple[float, ...]
    probabilities: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class HiddenGroup:
    """A group of unlike units whose failures stay hidden until the mission ends.

    Over so many `missions` between two tests the units fail with `units`, in the order of the
    units, each of the quantity for itself, so that the group fails with `group`, `None` where a
    common cause or spares are in it. With the mean hazard of one of these missions fails a group
    of which each unit fails with `like`. The function has the `share` of what survives that:
    1 - p = (1 - like)^(share / times), of `times` visits in a mission.
    """

    units: tuple[float, ...]
    group: float | None
    like: float
    share: float
    times: int
    missions: float = 1.0


@dataclass(frozen=True, slots=True)
class GroupDerivation:
    """How the units' figures become the block's one value, before rounding.

    `hazard` is the sum over all units and visits, of which there are `visits`, each as often as its
    weight says. `is_mean`: the value is 1 - exp(-mean hazard),
    as of units that are each needed, and of units that are alike. Else the group is `hidden`, or
    renewed at each visit and fails in the visits with `renewed`; that is empty where spares or a
    common cause make it more than so many units out of so many.
    """

    redundancy: Redundancy
    visits: int
    quantity: int
    hazard: float
    is_mean: bool
    value: float
    hidden: HiddenGroup | None = None
    renewed: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class BlockValue:
    """What stands in the block: its text, and what the tool computes, as text.

    `is_kept`: the text was computed before and stays, for the value is within the noise of it.
    """

    text: str
    computed: str
    is_pinned: bool = False
    is_omitted: bool = False
    is_kept: bool = False
    reason: str | None = None


@dataclass(frozen=True, slots=True)
class ComponentDerivation:
    """One component of the function: its terms, its units, their group and the block."""

    name: str
    redundancy: str
    always_active: bool
    source: str | None
    load_law: LoadLaw | None
    age_s: float
    terms: tuple[TermDerivation, ...]
    units: tuple[UnitDerivation, ...]
    group: GroupDerivation
    block: BlockValue | None


@dataclass(frozen=True, slots=True)
class FunctionDerivation:
    """Everything behind one function's block, in the order of the block.

    `times` is how often a mission visits the function; `by_hand` names the components that a
    user added to the block, of which nothing is computed.
    """

    function: str
    file: str
    active: ActiveMode
    times: int
    visits: tuple[VisitOfFunction, ...]
    components: tuple[ComponentDerivation, ...]
    by_hand: tuple[str, ...] = ()
