"""Derive the figures of one function's block, step by step.

Nothing here is computed unless asked for. It goes through the same terms as the computation of the
blocks: rate, time or count, load, hazard, probability, and the rule by which a group has one value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import Decimal

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import computed_probability, computed_redundancy
from tracerisk.adder.figures.computed import function_uses, group_values, use_of
from tracerisk.adder.figures.derivation import (
    BlockValue,
    ComponentDerivation,
    FunctionDerivation,
    GroupDerivation,
    HiddenGroup,
    LoadOfUnit,
    TermDerivation,
    TermOfUnit,
    UnitDerivation,
    VisitOfFunction,
)
from tracerisk.adder.quantify.component_activity import (
    ComponentUse,
    FunctionVisits,
    UnitUse,
    visits_by_function,
)
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.adder.quantify.function_use import FunctionUse, mission_probability
from tracerisk.adder.quantify.hidden_groups import hidden_hazards, over_mission, repaired_hazard
from tracerisk.adder.quantify.outcome import Outcome, at_least
from tracerisk.adder.quantify.probability import Term, failure_probability, hazard_of, survival_log
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.load import wear_s
from tracerisk.common.hardware.model import Hardware
from tracerisk.config import ActiveMode
from tracerisk.errors import InputError, one_of
from tracerisk.trace import Trace


def function_named(trace: Trace, name: str) -> FunctionRef:
    """Return the function of a trace that has this name in the model.

    Raises InputError, with the names that there are, for an unknown one.
    """
    names = model_names([function.ref for function in trace.functions])
    for ref, known in names.items():
        if known == name:
            return ref
    raise InputError(f"no function '{name}' in the trace; {one_of(names.values(), name)}")


def derive_function(
    trace: Trace,
    hardware: Hardware,
    function: FunctionRef,
    *,
    active: ActiveMode,
    block: RiskBlock | None = None,
    evidence: EvidenceShares | None = None,
) -> FunctionDerivation:
    """Return where the figures of a function come from; `block` is what stands in the source.

    Raises HardwareError where the description does not fit the trace.
    """
    visits = visits_by_function(trace)
    here = visits[function]
    components = []
    known = None if evidence is None else evidence.among(trace)
    for bound in bind(hardware, trace.elements):
        used = use_of(bound, trace, active, known)
        uses = function_uses(used, visits)
        if function in uses:
            group = _group(used, here, function, uses)
            components.append(_component(used, here.numbers, group, block, hardware.source))
    return FunctionDerivation(
        function=model_names([traced_function.ref for traced_function in trace.functions])[
            function
        ],
        file=function.file,
        active=active,
        times=here.total,
        visits=tuple(
            VisitOfFunction(n + 1, weight, trace.visits[n].start_s, trace.visits[n].duration_s)
            for n, weight in zip(here.numbers, here.weights, strict=True)
        ),
        components=tuple(components),
        by_hand=tuple(component.name for component in block.components if component.added)
        if block
        else (),
    )


def _component(
    used: ComponentUse,
    visits: Sequence[int],
    group: GroupDerivation,
    block: RiskBlock | None,
    source: str | None,
) -> ComponentDerivation:
    """Return the steps of a component; `source` is that of the description as a whole."""
    component = used.component
    distinct = list(dict.fromkeys(used.units))
    first = distinct[0]
    units = tuple(_unit(unit_use, used.units.count(unit_use), visits) for unit_use in distinct)
    terms = tuple(
        TermDerivation(
            figure=term.figure,
            counts=term.counts,
            share=term.share,
            mode=None if term.mode is None else term.mode.name,
            states=term.states,
            demands=term.demands,
            units=tuple(_term(unit_use.terms[index], unit_use, visits) for unit_use in distinct),
        )
        for index, term in enumerate(first.terms)
    )
    entries = (
        {component_entry.name: component_entry for component_entry in block.components}
        if block is not None
        else {}
    )
    return ComponentDerivation(
        name=component.name,
        redundancy=computed_redundancy(component.redundancy).text,
        always_active=component.always_active,
        source=component.source or source,
        load_law=component.load_law,
        age_s=component.age_s,
        terms=terms,
        units=units,
        group=group,
        block=_block_value(entries.get(component.name), group.value),
    )


def _group(
    used: ComponentUse,
    visits: FunctionVisits,
    function: FunctionRef,
    uses: Mapping[FunctionRef, FunctionUse],
) -> GroupDerivation:
    values = group_values(used, uses)
    value = values[function]
    redundancy, quantity = used.component.redundancy, used.bound.quantity
    rows = used.hazards(visits.numbers)
    hazard = math.fsum(
        weight * h for weight, row in zip(visits.weights, rows, strict=True) for h in row
    )
    count = sum(visits.weights)
    mean = failure_probability(hazard / (count * quantity))
    is_mean = math.isclose(mean, value, rel_tol=1e-12, abs_tol=0.0)
    hidden: HiddenGroup | None = None
    renewed: tuple[float, ...] = ()
    if not is_mean and redundancy.detected == "mission_start":
        hidden = _hidden(used, function, uses, values)
    elif not is_mean and not redundancy.has_spares and not redundancy.common_cause:
        renewed = tuple(_p_group_fails(list(map(failure_probability, row)), used) for row in rows)
    return GroupDerivation(redundancy, count, quantity, hazard, is_mean, value, hidden, renewed)


def _hidden(
    used: ComponentUse,
    function: FunctionRef,
    uses: Mapping[FunctionRef, FunctionUse],
    values: Mapping[FunctionRef, float],
) -> HiddenGroup:
    renewal = used.renewal
    units = tuple(
        failure_probability(
            -renewal.missions * survival_log(mission_probability(list(uses.values()), unit))
        )
        for unit in range(used.bound.quantity)
    )
    hazards = {ref: -uses[ref].times * survival_log(value) for ref, value in values.items()}
    whole = math.fsum(hazards.values())
    group = used.component.redundancy
    own, common = over_mission([hidden_hazards(use, group) for use in uses.values()])
    apart: float | None = None
    hazard = float(common)
    if renewal.repair is not None:
        mean = float(repaired_hazard(own, group, renewal, renewal.repair))
        hazard += mean
        apart = failure_probability(mean)
    elif not group.has_spares:
        between_tests = [failure_probability(renewal.missions * float(unit.hazard)) for unit in own]
        apart = _p_group_fails(between_tests, used)
        hazard += -survival_log(apart) / renewal.missions
    is_shown = group.common_cause or group.has_spares or renewal.repair is not None
    return HiddenGroup(
        units=units,
        group=None if is_shown else _p_group_fails(units, used),
        like=failure_probability(whole),
        share=hazards[function] / whole if whole else 0.0,
        times=round(uses[function].times),
        missions=renewal.missions,
        repair=renewal.repair,
        in_mission=renewal.in_mission,
        beta=group.common_cause or 0.0,
        apart=apart,
        common=float(common),
        hazard=hazard,
    )


def _p_group_fails(units: Sequence[float], used: ComponentUse) -> float:
    """Return the probability that too few of independent units are left."""
    threshold = used.bound.quantity - used.component.redundancy.required + 1
    outcomes = [Outcome(Decimal(p), 1 - Decimal(p)) for p in units]
    return float(at_least(threshold, outcomes).p)


def _unit(unit: UnitUse, count: int, visits: Sequence[int]) -> UnitDerivation:
    hazards = tuple(unit.hazard(visit) for visit in visits)
    return UnitDerivation(
        element=unit.element,
        count=count,
        in_use_s=unit.mission.in_use_s,
        hazards=hazards,
        probabilities=tuple(map(failure_probability, hazards)),
    )


def _term(term: Term, unit: UnitUse, visits: Sequence[int]) -> TermOfUnit:
    uses = [unit.uses[visit] for visit in visits]
    amounts = tuple(term.amount(use) for use in uses)
    wearing = tuple(term.wearing_s(use) for use in uses)
    counted = tuple(map(term.counted, amounts, wearing))
    load = None
    if term.load is not None:
        law = term.load.law
        load = LoadOfUnit(
            term.load.reference_speed,
            tuple(wear_s(law, use.known_exposure) if term.wears else 0.0 for use in uses),
            tuple(use.known_exposure.travel_s if term.wears else 0.0 for use in uses),
            wearing,
        )
    hazards = tuple(
        term.ending(use, hazard_of(term.rate, term.share, value))
        for use, value in zip(uses, counted, strict=True)
    )
    ends = tuple(term.ends[use.visit] for use in uses) if term.ends else ()
    return TermOfUnit(term.rate, amounts, counted, hazards, load, ends)


def _block_value(entry: ComponentEntry | None, value: float) -> BlockValue | None:
    if entry is None:
        return None
    computed = computed_probability(value).text
    field = entry.probability
    return BlockValue(
        text=field.text,
        computed=computed,
        is_pinned=field.pinned,
        is_omitted=entry.omitted,
        is_kept=not field.pinned and not entry.omitted and field.text != computed,
        reason=entry.reason if entry.omitted else field.reason,
    )
