"""The risk blocks that a trace and a hardware description give."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.failures import FailureModes
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.figures.assumptions import (
    assumptions_of,
    borderline,
    uncounted,
    uncounted_holds,
)
from tracerisk.adder.figures.failure_outcomes import FailureOutcomes, later_functions
from tracerisk.adder.figures.following import (
    ProfileText,
    check_profile,
    next_counts,
    pinned_next,
)
from tracerisk.adder.figures.instances import ComponentInstances, instances_of
from tracerisk.adder.quantify.component_activity import (
    ComponentUse,
    FunctionVisits,
    component_use,
    mission_time,
    visits_by_function,
    visits_of_mission,
)
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.adder.quantify.figure_shares import ending_share, figure_shares
from tracerisk.adder.quantify.function_use import FunctionUse
from tracerisk.adder.quantify.groups import group_unit_probabilities
from tracerisk.adder.quantify.probability import failure_probability
from tracerisk.common.evidence import EVIDENCE_NAME
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.binding import BoundComponent, bind
from tracerisk.common.hardware.model import Component, Hardware, is_assumed
from tracerisk.common.hardware.use import UnknownUseError
from tracerisk.config import ActiveMode
from tracerisk.errors import HardwareError, Location
from tracerisk.trace import Trace

_HOLDING = "active: only motion counts, and the time in which joints hold something does not"


@dataclass(frozen=True, slots=True)
class ComputedBlocks:
    """The blocks of one trace and what stands behind them."""

    blocks: Mapping[FunctionRef, RiskBlock]
    """The computed block of each function."""
    exposures: Mapping[FunctionRef, Mapping[str, float]]
    """The time active by function and component, summed over visits and averaged over units [s]."""
    observed: Mapping[FunctionRef, tuple[str, ...]]
    """The components seen active in each function, without those that are always active."""
    assumptions: tuple[str, ...]
    """Sentences that a reader must know to read the figures."""
    instances: tuple[ComponentInstances, ...] = ()
    """The units behind the one value of each component, in the order of the description."""

    @property
    def names(self) -> dict[FunctionRef, str]:
        """Each function's name in the model."""
        return model_names(self.blocks)

    @property
    def exposures_by_name(self) -> dict[str, Mapping[str, float]]:
        """The exposures by the function's name in the model."""
        return {self.names[ref]: row for ref, row in self.exposures.items()}


def compute_blocks(
    trace: Trace,
    hardware: Hardware,
    *,
    active: ActiveMode,
    profile: ProfileText | None = None,
    evidence: EvidenceShares | None = None,
) -> ComputedBlocks:
    """Return the block of each relevant function of the trace.

    A profile pins the `next` of the functions it names. With `evidence` the values count only
    failures that end the mission, or from which it recovers, and the blocks say so.
    Raises HardwareError where the description does not fit the robot or describes nothing that it
    has, or a figure needs an exposure that the trace does not hold; InputError where the profile
    names a function that the trace does not.
    """
    bound = bind(hardware, trace.elements)
    if hardware.components and not bound:
        raise HardwareError(
            "describes only optional components, of which the robot has none, so that nothing "
            "could fail; describe one that it has (tracerisk robots NAME lists joints and "
            "sensors), or one that is active always",
            Location(hardware.file),
        )
    _check_tests(bound, trace)
    counts = next_counts(trace)
    names = model_names([function.ref for function in trace.functions])
    check_profile(profile or {}, list(names.values()))
    visits = visits_by_function(trace)
    known = None if evidence is None else evidence.among(trace)
    used = [use_of(bound_component, trace, active, known) for bound_component in bound]
    uses = [function_uses(component_use, visits) for component_use in used]
    shows_in = later_functions({names[ref]: row for ref, row in counts.items()})
    entries = []
    for use, by_function in zip(used, uses, strict=True):
        outcomes = FailureOutcomes(use, known)
        sections = {
            ref: outcomes.in_function(visits[ref], names[ref], shows_in) for ref in by_function
        }
        entries.append(_entries(use, by_function, sections))
    blocks = {}
    exposures = {}
    observed = {}
    for function in trace.functions:
        ref, name, numbers = function.ref, names[function.ref], visits[function.ref].numbers
        following = computed_next(counts[ref])
        if profile and name in profile:
            following = pinned_next(profile[name], following.text, name)
        blocks[ref] = RiskBlock(
            name=ref.name,
            call_sequence=computed_count(function.call_sequence),
            next=following,
            components=tuple(entry[ref] for entry in entries if ref in entry),
            has_evidence=evidence is not None and evidence.evidence.counts,
        )
        here = [use for use, entry in zip(used, entries, strict=True) if ref in entry]
        exposures[ref] = _exposures(here, numbers)
        observed[ref] = _seen_active(here, numbers)
    times = visits_of_mission(trace)
    instances = tuple(
        _with_shares(
            instances_of(component_use, use),
            component_use,
            [visits[ref].numbers for ref in use],
            times,
        )
        for component_use, use in zip(used, uses, strict=True)
    )
    assumed = (
        *assumptions_of(used),
        *uncounted(trace, bound),
        *uncounted_holds(trace, bound),
        *borderline(trace, bound),
        *_evidence_words(known, used),
        *((_HOLDING,) if active == "moving" else ()),
    )
    return ComputedBlocks(blocks, exposures, observed, assumed, instances)


def _exposures(used: Sequence[ComponentUse], visits: Sequence[int]) -> dict[str, float]:
    """Return the time for which each component was active in some visits [s], where it is known."""
    return {
        component_use.component.name: seconds
        for component_use in used
        if (seconds := _mean_exposure(component_use, visits)) is not None
    }


def _seen_active(used: Sequence[ComponentUse], visits: Sequence[int]) -> tuple[str, ...]:
    """Return the components seen active in some visits, without those that always are."""
    return tuple(
        component_use.component.name
        for component_use in used
        if not component_use.component.always_active
        and any(component_use.is_active[visit] for visit in visits)
    )


def _evidence_words(
    evidence: EvidenceShares | None, used: Sequence[ComponentUse]
) -> tuple[str, ...]:
    """Return what a reader must know of figures that take evidence; nothing for others."""
    names = sorted(
        component_use.component.name
        for component_use in used
        if any(term.ends for unit in component_use.units for term in unit.terms)
    )
    if evidence is None or not names:
        return ()
    leads_back = any(
        outcome.is_back
        for component_use in used
        for unit in component_use.units
        for outcome in evidence.outcomes(component_use.bound, unit.element)
    )
    ended = "ended the mission of the scenario"
    ended += ", or led back to a function," if leads_back else ""
    words = [
        f"evidence: {', '.join(names)} count only what {ended} in "
        f"{evidence.evidence.drawn} drawn failures on the twin ({EVIDENCE_NAME}); redundant "
        "components count in full"
    ]
    assumed = sorted(
        component_use.component.name
        for component_use in used
        if component_use.component.name in names
        and any(mode.source and is_assumed(mode.source) for mode in component_use.component.modes)
    )
    if assumed:
        words.append(
            f"evidence: the fractions of the failure modes of {', '.join(assumed)} are assumed"
        )
    return tuple(words)


def _with_shares(
    instances: ComponentInstances,
    used: ComponentUse,
    visits: Sequence[Sequence[int]],
    times: Sequence[float],
) -> ComponentInstances:
    times_of_visit = {number: times[number] for here in visits for number in here}
    if not times_of_visit:
        return instances
    return replace(
        instances,
        figure_shares=figure_shares(used, times_of_visit),
        ending=ending_share(used, times_of_visit),
    )


def use_of(
    bound: BoundComponent,
    trace: Trace,
    active: ActiveMode,
    evidence: EvidenceShares | None = None,
) -> ComponentUse:
    """Return what the units of a component do over the run.

    Raises HardwareError where the trace does not hold what a figure needs.
    """
    try:
        return component_use(bound, trace, active, evidence)
    except UnknownUseError as error:
        raise _unknown(bound.component, error) from error


def function_uses(
    used: ComponentUse, visits: Mapping[FunctionRef, FunctionVisits]
) -> dict[FunctionRef, FunctionUse]:
    """Return, for each function in which a component counts, how its units fail in each visit."""
    uses = {}
    for ref, here in visits.items():
        if used.is_at_stake(here.numbers):
            rows = _weighted(_hazards(used, here.numbers), here.weights, used.component)
            units = [list(map(failure_probability, row)) for row in rows]
            uses[ref] = FunctionUse(units, here.total)
    return uses


def _weighted(
    rows: list[list[float]], weights: Sequence[int], component: Component
) -> list[list[float]]:
    """Return rows of hazards that all occur equally often in a mission.

    Visits before a cycle and visits in it do not: each row is repeated by its weight or, where only
    the sum over visits matters, one mean row stands for all.
    """
    if all(weight == 1 for weight in weights):
        return rows
    group = component.redundancy
    is_hidden = group.detected == "mission_start"
    if not group.common_cause and (is_hidden or not group.is_redundant):
        total = sum(weights)
        columns = zip(*rows, strict=True)
        return [[math.fsum(map(operator.mul, weights, column)) / total for column in columns]]
    return [row for row, weight in zip(rows, weights, strict=True) for _ in range(weight)]


def group_values(
    used: ComponentUse, uses: Mapping[FunctionRef, FunctionUse]
) -> dict[FunctionRef, float]:
    """Return the one probability, before rounding, that stands in the block of each function."""
    if not uses:
        return {}
    values = group_unit_probabilities(list(uses.values()), used.component.redundancy, used.renewal)
    return dict(zip(uses, values, strict=True))


def _entries(
    used: ComponentUse,
    uses: Mapping[FunctionRef, FunctionUse],
    failures: Mapping[FunctionRef, Field[FailureModes]],
) -> dict[FunctionRef, ComponentEntry]:
    """Return what the block of each function says of a component that counts there."""
    component = used.component
    return {
        ref: ComponentEntry(
            name=component.name,
            probability=computed_probability(value),
            quantity=computed_count(used.bound.quantity),
            redundancy=computed_redundancy(component.redundancy),
            failures=failures[ref],
        )
        for ref, value in group_values(used, uses).items()
    }


def _hazards(used: ComponentUse, visits: Sequence[int]) -> list[list[float]]:
    try:
        return used.hazards(visits)
    except UnknownUseError as error:
        raise _unknown(used.component, error) from error


def _unknown(component: Component, error: UnknownUseError) -> HardwareError:
    return HardwareError(
        f"component '{component.name}': {error} from this trace; {error.advice}",
        component.location,
    )


def _mean_exposure(used: ComponentUse, visits: Sequence[int]) -> float | None:
    seconds = [unit.seconds(visit) for visit in visits for unit in used.units]
    known = [second for second in seconds if second is not None]
    return math.fsum(known) / used.bound.quantity if len(known) == len(seconds) else None


def _check_tests(bound: Sequence[BoundComponent], trace: Trace) -> None:
    """Raise HardwareError where it is unknown what may be failed when a mission starts."""
    for bound_component in bound:
        component = bound_component.component
        if component.repair is not None:
            what = f"repair of {component.repair.mean_time_s:.4g} s"
        elif component.test_interval_s is not None:
            what = f"test interval of {component.test_interval_s:.4g} s"
        else:
            continue
        if mission_time(trace) is not None:
            continue
        raise HardwareError(
            f"component '{component.name}': its {what} cannot be compared with the time of a "
            "mission, which this trace does not hold; test the group before each mission and "
            "write 'detected: mission_start'",
            component.location,
        )
