"""From a unit's figures and its use to a failure probability.

Each figure gives a hazard: a rate times what it counts in a visit, the time in use, on standby,
or the demands. Hazards of independent causes add up, and so do those of successive visits; the
failure probability is 1 - exp(-hazard) (constant hazard, independent demands: standard
reliability theory, e.g. IEC 61078; written with expm1 and log1p so that 1e-20 keeps its digits).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from tracerisk.adder.quantify.ageing import mean_ageing_rate
from tracerisk.common.hardware.load import UnitLoad
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    Demand,
    FailureFigure,
    FailureMode,
    State,
)
from tracerisk.common.hardware.use import (
    DEMANDS,
    STATES,
    Seconds,
    UnknownUseError,
    Use,
    demands_on,
    time_counted,
    usual_demand,
)
from tracerisk.common.traced.elements import ElementKind

Counted = Literal["time in use", "standby", "demands", "visits"]
"""What a term multiplies its rate with."""


@dataclass(frozen=True, slots=True)
class Term:
    """One summand of a unit's hazard: a figure, or the share of it that is one failure mode."""

    figure: FailureFigure
    """The figure in the hardware description."""
    counts: Counted
    """What the term counts."""
    rate: float
    """The hazard per second, demand or visit."""
    mode: FailureMode | None = None
    """The failure mode; `None` where the figure counts as a whole."""
    states: tuple[State, ...] | None = None
    """The states whose time counts; `None` for all time in use."""
    demands: tuple[Demand, ...] = ()
    """The demands that count; empty for a term that counts none."""
    load: UnitLoad | None = None
    """The load law of the unit; `None` for no effect of load."""
    seconds: Seconds | None = None
    """Returns the time that counts of an exposure [s]; `None` for a term that counts none."""
    ends: tuple[float, ...] = ()
    """The share of the hazard that ends the mission, by the visit's number in the trace,
    (n_visits,); empty where all of it does."""
    cells: tuple[str, int] = ("", 0)
    """The name of the set of drawn failures on which `ends` rests, and their number."""

    @property
    def share(self) -> float:
        """The fraction of the figure that the term is."""
        return 1.0 if self.mode is None else self.mode.fraction

    @property
    def wears(self) -> bool:
        """Whether wear counts: where the unit moves, for holding adds no rolling fatigue."""
        return self.load is not None and (self.states is None or "moving" in self.states)

    def amount(self, use: Use) -> float:
        """Return what a visit has of what the term counts: seconds, demands or visits.

        Raises UnknownUseError where the trace does not hold it.
        """
        if self.seconds is not None:
            return self.seconds(use.known_exposure)
        if self.counts == "demands":
            return float(demands_on(use.known_exposure, self.demands))
        if self.counts == "visits":
            return 1.0 if use.is_active else 0.0
        if use.standby_s is None:
            raise UnknownUseError("the time on standby")
        return use.standby_s

    def wearing_s(self, use: Use) -> float:
        """Return for how long a visit wears the unit, at reference load and speed [s]."""
        if self.load is None or not self.wears:
            return 0.0
        return self.load.wearing_s(use.known_exposure)

    def counted(self, amount: float, wearing_s: float) -> float:
        """Return the amount as weighted by the load law, or unchanged without one."""
        return amount if self.load is None else self.load.counted_s(amount, wearing_s)

    def hazard(self, use: Use) -> float:
        """Return the term's hazard in a visit.

        Raises UnknownUseError where the trace does not hold what it counts.
        """
        counted = self.amount(use)
        if self.load is not None:
            counted = self.load.counted_s(counted, self.wearing_s(use))
        return self.ending(use, hazard_of(self.rate, self.share, counted))

    def ending(self, use: Use, hazard: float) -> float:
        """Return what of a visit's hazard ends the mission."""
        return hazard * self.ends[use.visit] if self.ends else hazard


@dataclass(frozen=True, slots=True)
class UnitMission:
    """What a unit's hazards depend on besides the single visit."""

    kind: ElementKind | None
    """The kind of the element in which the twin sees it; `None` for a component that is always
    active."""
    states: tuple[State, ...] | None = None
    """The states that count where no mode says otherwise; `None` for all."""
    load: UnitLoad | None = None
    """The load law of the unit; `None` for no effect of load."""
    in_use_s: float = 0.0
    """The time in use over the mission, as the load law counts it; for wear-out only [s]."""


def terms_of(component: Component, mission: UnitMission) -> tuple[Term, ...]:
    """Return the summands of the hazard of one unit of a component, in the order of its figures.

    Where there are failure modes, each mode counts the states and demands that it names, and a
    figure has one term for each mode that names any of those the figure counts.
    """
    terms: list[Term] = []
    for figure in component.figures:
        if figure.per is Basis.VISIT:
            terms.append(Term(figure, "visits", _rate(figure)))
        elif figure.per is Basis.DEMAND:
            terms += _demand_terms(figure, component.modes_by_use, mission)
        elif figure.standby:
            terms.append(Term(figure, "standby", _rate(figure)))
        else:
            terms += _time_terms(figure, component, mission)
    return tuple(terms)


def unit_hazard(terms: Sequence[Term], use: Use) -> float:
    """Return the hazard of one unit during one visit, all its terms together."""
    if len(terms) == 1:
        return terms[0].hazard(use)
    return math.fsum(term.hazard(use) for term in terms)


def failure_probability(hazard: float) -> float:
    """Return 1 - exp(-hazard)."""
    return -math.expm1(-hazard)


def hazard_of(rate: float, share: float, counted: float) -> float:
    """Return rate x share x amount; even with an infinite rate, what is not used does not fail."""
    return rate * share * counted if counted and share else 0.0


def survival_log(p_failure: float) -> float:
    """Return ln(1-p), minus infinity for certain failure."""
    return -math.inf if p_failure >= 1.0 else math.log1p(-p_failure)


def _rate(figure: FailureFigure) -> float:
    """Return the hazard per demand, visit or second of a figure that does not age."""
    rate = figure.value if figure.kind == "failure_rate" else -survival_log(figure.value)
    span = figure.per.seconds
    return rate if span is None else rate / span


def _demand_terms(
    figure: FailureFigure, modes: Sequence[FailureMode], mission: UnitMission
) -> list[Term]:
    if mission.kind is None:
        raise UnknownUseError("the number of demands")
    rate = _rate(figure)
    if not modes:
        demand = figure.demand or usual_demand(mission.kind)
        return [Term(figure, "demands", rate, demands=(demand,))]
    wanted = DEMANDS if figure.demand is None else (figure.demand,)
    terms = []
    for mode in modes:
        named = tuple(demand for demand in wanted if demand in mode.when)
        if named:
            terms.append(Term(figure, "demands", rate, mode, demands=named))
    return terms


def _time_terms(figure: FailureFigure, component: Component, mission: UnitMission) -> list[Term]:
    if figure.kind == "weibull":
        rate = mean_ageing_rate(figure, component.age_s, mission.in_use_s)
    else:
        rate = _rate(figure)
    load = mission.load
    if not component.modes_by_use:
        seconds = time_counted(mission.states)
        return [Term(figure, "time in use", rate, None, mission.states, load=load, seconds=seconds)]
    terms = []
    for mode in component.modes:
        named = tuple(state for state in STATES if state in mode.when)
        if named:
            seconds = time_counted(named)
            terms.append(Term(figure, "time in use", rate, mode, named, load=load, seconds=seconds))
    return terms
