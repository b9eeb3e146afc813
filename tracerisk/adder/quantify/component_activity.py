"""What each unit of a component does in the visits of a trace, and over the mission."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.adder.quantify.probability import Term, UnitMission, terms_of, unit_hazard
from tracerisk.adder.quantify.repaired_groups import EACH_MISSION, Renewal
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.binding import BoundComponent
from tracerisk.common.hardware.load import UnitLoad, mean_speed, wear_s
from tracerisk.common.hardware.model import Component, LoadLaw
from tracerisk.common.hardware.use import (
    Seconds,
    UnknownUseError,
    Use,
    counted_states,
    time_counted,
    time_in_use,
)
from tracerisk.common.traced.elements import ElementKind, Exposure
from tracerisk.config import ActiveMode
from tracerisk.trace import Trace, Visit

SHORTEST_ACTIVITY_S = 0.05
"""A component counts as active in a function if a state lasted this long [s]."""

_AT_REST = Exposure()


@dataclass(frozen=True, slots=True)
class UnitUse:
    """One unit over the run."""

    element: str | None
    """The element in which the twin sees it; `None` for a component that is always active."""
    mission: UnitMission
    """What the unit's hazards depend on besides the single visit."""
    terms: tuple[Term, ...]
    """The summands of its hazard."""
    uses: tuple[Use, ...]
    """The use of the unit in each visit of the trace, (n_visits,)."""

    def hazard(self, visit: int) -> float:
        """Return the hazard of the unit in a visit, by its number in the trace.

        Raises UnknownUseError where the trace does not hold what a figure needs.
        """
        return unit_hazard(self.terms, self.uses[visit])

    def seconds(self, visit: int) -> float | None:
        """Return the time that counts where no mode says otherwise [s], `None` if not known."""
        exposure = self.uses[visit].exposure
        return None if exposure is None else time_counted(self.mission.states)(exposure)


@dataclass(frozen=True, slots=True)
class ComponentUse:
    """The units of a component over the run."""

    bound: BoundComponent
    """The component with its elements."""
    units: tuple[UnitUse, ...]
    """One entry for each of the quantity; units that share an element have the same."""
    is_active: tuple[bool, ...]
    """Whether the component counts as active in each visit of the trace, (n_visits,)."""
    renewal: Renewal = EACH_MISSION
    """When failed units are replaced whose failures stay hidden."""

    @property
    def component(self) -> Component:
        """The component itself."""
        return self.bound.component

    def is_at_stake(self, visits: Sequence[int]) -> bool:
        """Whether it counts in a function: it is active in a visit, used once, or fails idle."""
        if not visits:
            return False
        if self.component.always_active or any(self.is_active[visit] for visit in visits):
            return True
        return any(
            term.counts in ("demands", "standby") and term.amount(unit.uses[visit]) > 0.0
            for unit in self.units
            for term in unit.terms
            for visit in visits
        )

    def hazards(self, visits: Sequence[int]) -> list[list[float]]:
        """Return the hazard of each unit in each of the visits: (n_visits, quantity).

        Raises UnknownUseError where the trace does not hold what a figure needs.
        """
        rows = []
        for visit in visits:
            row: list[float] = []
            for index, unit in enumerate(self.units):
                same = index > 0 and unit is self.units[index - 1]
                row.append(row[-1] if same else unit.hazard(visit))
            rows.append(row)
        return rows


@dataclass(frozen=True, slots=True)
class FunctionVisits:
    """The visits of one function."""

    numbers: tuple[int, ...]
    """The index of each visit in the trace, (n_visits,)."""
    times: tuple[Fraction, ...]
    """How often a mission has each visit, (n_visits,)."""

    @property
    def total(self) -> int:
        """How often a mission visits the function."""
        return round(sum(self.times))

    @property
    def weights(self) -> tuple[int, ...]:
        """The times in the smallest whole numbers: all 1 if each visit occurs equally often."""
        common = math.lcm(*(time.denominator for time in self.times))
        whole = [int(time * common) for time in self.times]
        divisor = math.gcd(*whole)
        return tuple(number // divisor for number in whole)


def times_in_mission(trace: Trace) -> tuple[Fraction, ...]:
    """Return how often each visit of the run comes in a mission.

    Once, except in a cycle: there each visit seen stands for its share of the cycles that the
    mission is declared to have.
    """
    cycle = trace.cycle
    if cycle is None:
        return (Fraction(1),) * len(trace.visits)
    after = len(trace.visits) - cycle.first_visit
    seen = max(1, after // cycle.visits)
    in_cycle = min(after, seen * cycle.visits)
    return (
        *(Fraction(1),) * cycle.first_visit,
        *(Fraction(cycle.mission_cycles, seen),) * in_cycle,
        *(Fraction(0),) * (after - in_cycle),
    )


def visits_of_mission(trace: Trace) -> tuple[float, ...]:
    """Return how often each visit of the run comes in a mission: see `times_in_mission`."""
    return tuple(map(float, times_in_mission(trace)))


def mission_duration_s(trace: Trace) -> float | None:
    """Return how long a mission lasts [s], with as many cycles as it is declared to have.

    `None` where the trace does not say.
    """
    return trace.end.simulated_s if trace.cycle is None else mission_time(trace)


def visits_by_function(trace: Trace) -> dict[FunctionRef, FunctionVisits]:
    """Return the visits of each function, in the order of the functions."""
    table: dict[FunctionRef, list[int]] = {function.ref: [] for function in trace.functions}
    times = times_in_mission(trace)
    for number, visit in enumerate(trace.visits):
        if times[number]:
            table[visit.function].append(number)
    return {
        ref: FunctionVisits(tuple(numbers), tuple(times[number] for number in numbers))
        for ref, numbers in table.items()
    }


def mission_time(trace: Trace) -> float | None:
    """Return the time of all visits of a mission [s], `None` where the trace does not hold it."""
    times = visits_of_mission(trace)
    total = 0.0
    for visit, comes in zip(trace.visits, times, strict=True):
        if visit.duration_s is None:
            return None
        total += comes * visit.duration_s
    return total


def renewal_of(component: Component, trace: Trace, *, is_even: bool) -> Renewal:
    """Return when the failed units of a group are replaced, by the time of a mission.

    Repair goes on within missions only where a unit's hazard `is_even` over them.
    """
    if component.repair is None and component.test_interval_s is None:
        return EACH_MISSION
    mission_s = mission_time(trace)
    if component.repair is not None and mission_s:
        repairs = mission_s / component.repair.mean_time_s
        return Renewal(repair=repairs, in_mission=component.repair.in_mission and is_even)
    if component.test_interval_s is not None and mission_s:
        return Renewal(missions=max(1.0, component.test_interval_s / mission_s))
    return EACH_MISSION


def component_use(
    bound: BoundComponent,
    trace: Trace,
    active: ActiveMode,
    evidence: EvidenceShares | None = None,
) -> ComponentUse:
    """Return what the units of a component do in the visits of a trace.

    With `evidence` each unit's hazard is that which ends the mission, or from which it recovers by
    going back to a function of the trace.

    Raises UnknownUseError where the trace does not hold what a figure needs.
    """
    component = bound.component
    evidence = None if evidence is None else evidence.among(trace)
    times = visits_of_mission(trace)
    if component.always_active:
        is_active = (True,) * len(trace.visits)
        uses = tuple(_always(number, visit) for number, visit in enumerate(trace.visits))
        unit = _unit_use(None, None, component, active, uses, trace.visits, times)
        unit = _ending(unit, bound, evidence)
        is_even = not any(term.ends for term in unit.terms)
        renewal = renewal_of(component, trace, is_even=is_even)
        return ComponentUse(bound, (unit,) * bound.quantity, is_active, renewal)
    kinds = {element.name: element.kind for element in trace.elements}
    is_active = tuple(_is_active(bound, visit, active, kinds) for visit in trace.visits)
    units = []
    for name, same in itertools.groupby(bound.units()):
        uses = tuple(
            Use(visit.exposures.get(name, _AT_REST), here, visit=number)
            for number, (visit, here) in enumerate(zip(trace.visits, is_active, strict=True))
        )
        unit = _unit_use(name, kinds[name], component, active, uses, trace.visits, times)
        units += [_ending(unit, bound, evidence)] * len(list(same))
    renewal = renewal_of(component, trace, is_even=False)
    return ComponentUse(bound, tuple(units), is_active, renewal)


def _ending(unit: UnitUse, bound: BoundComponent, evidence: EvidenceShares | None) -> UnitUse:
    """Return a unit whose hazard is that which evidence says to matter."""
    if evidence is None:
        return unit
    return replace(unit, terms=evidence.applied(bound, unit.element, unit.terms, unit.uses))


def _always(number: int, visit: Visit) -> Use:
    exposure = None if visit.duration_s is None else Exposure(active_s=visit.duration_s)
    return Use(exposure, standby_s=0.0, visit=number)


def _is_active(
    bound: BoundComponent, visit: Visit, active: ActiveMode, kinds: Mapping[str, ElementKind]
) -> bool:
    for name in bound.elements:
        if name not in visit.exposures:
            continue
        exposure = visit.exposures[name]
        if exposure is None:
            return True
        counts_all = counted_states(active, kinds[name]) is None
        longest = exposure.longest_active_s if counts_all else exposure.longest_moving_s
        if longest >= SHORTEST_ACTIVITY_S:
            return True
    return False


def _unit_use(
    name: str | None,
    kind: ElementKind | None,
    component: Component,
    active: ActiveMode,
    uses: tuple[Use, ...],
    visits: Sequence[Visit],
    times: Sequence[float],
) -> UnitUse:
    states = None if kind is None else counted_states(active, kind)
    in_use = time_in_use(states, component.modes)
    load = None
    if component.load_law is not None:
        load = _unit_load(component.load_law, uses, times)
    in_use_s = 0.0
    if any(figure.kind == "weibull" for figure in component.figures):
        in_use_s = _time_in_use(in_use, load, uses, times)
    if any(figure.standby for figure in component.figures) and kind is not None:
        uses = _with_standby(in_use, uses, visits, times)
    mission = UnitMission(kind, states, load, in_use_s)
    return UnitUse(name, mission, terms_of(component, mission), uses)


def _unit_load(law: LoadLaw, uses: Sequence[Use], times: Sequence[float]) -> UnitLoad:
    if law.reference_speed is not None:
        return UnitLoad(law, law.reference_speed)
    travel_s = moving_s = 0.0
    for use, comes in zip(uses, times, strict=True):
        exposure = use.known_exposure
        wear_s(law, exposure)  # called only to raise where the exposure is unknown
        travel_s += comes * exposure.travel_s
        moving_s += comes * exposure.moving_s
    return UnitLoad(law, mean_speed(travel_s, moving_s))


def _time_in_use(
    in_use: Seconds, load: UnitLoad | None, uses: Sequence[Use], times: Sequence[float]
) -> float:
    """Return the time in use over the mission [s], as the load law counts it."""
    total = 0.0
    for use, comes in zip(uses, times, strict=True):
        exposure = use.known_exposure
        seconds = in_use(exposure)
        if load is not None:
            seconds = load.counted_s(seconds, load.wearing_s(exposure))
        total += comes * seconds
    return total


def _with_standby(
    in_use: Seconds, uses: Sequence[Use], visits: Sequence[Visit], times: Sequence[float]
) -> tuple[Use, ...]:
    """Return the uses with the time on standby of each visit.

    A unit can be in use for longer than its visit lasts, because what it does by a command of the
    visit counts in that visit. Its standby time would then be negative; the deficit is taken from
    the other visits in proportion, so that the sum is that of the mission.
    """
    idle = []
    for use, visit in zip(uses, visits, strict=True):
        if visit.duration_s is None:
            raise UnknownUseError("the time on standby")
        idle.append(visit.duration_s - in_use(use.known_exposure))
    spans = [comes * seconds for comes, seconds in zip(times, idle, strict=True)]
    total = math.fsum(spans)
    positive = math.fsum(span for span in spans if span > 0.0)
    left = max(0.0, total) / positive if positive > 0.0 else 0.0
    return tuple(
        replace(use, standby_s=max(0.0, seconds) * left)
        for use, seconds in zip(uses, idle, strict=True)
    )
