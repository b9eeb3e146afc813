"""The risk blocks that a trace and a hardware description give."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tracerisk.adder.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.model_names import model_names
from tracerisk.adder.values import (
    DONE,
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
    profile_next,
)
from tracerisk.config import ActiveMode
from tracerisk.errors import HardwareError, InputError, one_of
from tracerisk.hardware.binding import BoundComponent, bind
from tracerisk.hardware.groups import group_unit_probability
from tracerisk.hardware.model import Basis, Hardware
from tracerisk.hardware.probability import Use, unit_probability
from tracerisk.trace import Cycle, Exposure, FunctionRef, Trace, Visit

SHORTEST_ACTIVITY_S = 0.05
"""A component counts as active in a function if a state lasted this long [s]."""

ProfileText = Mapping[str, Mapping[str, str]]
"""An operational profile: for each function the share of each target, as a person wrote it."""


@dataclass(frozen=True, slots=True)
class ComputedBlocks:
    """The blocks of one trace and what stands behind them.

    `exposures` are seconds active by function and component, summed over visits and averaged
    over units; `observed` the components seen active in each function, those that are always
    active left out; `assumptions` what a reader must know to read the figures.
    """

    blocks: Mapping[FunctionRef, RiskBlock]
    exposures: Mapping[FunctionRef, Mapping[str, float]]
    observed: Mapping[FunctionRef, tuple[str, ...]]
    assumptions: tuple[str, ...]

    @property
    def names(self) -> dict[FunctionRef, str]:
        """Each function's name in the model."""
        return model_names(self.blocks)

    @property
    def exposures_by_name(self) -> dict[str, Mapping[str, float]]:
        """The exposures by the function's name in the model."""
        return {self.names[ref]: row for ref, row in self.exposures.items()}


def compute_blocks(
    trace: Trace, hardware: Hardware, *, active: ActiveMode, profile: ProfileText | None = None
) -> ComputedBlocks:
    """Return the block of each relevant function of the trace.

    A profile pins the `next` of the functions it names.
    Raises HardwareError where the description does not fit the robot, or a figure needs an
    exposure that the trace does not tell; InputError where the profile names a
    function that the trace does not.
    """
    bound = bind(hardware, trace.elements)
    _check_tests(bound, trace)
    counts = next_counts(trace)
    names = model_names([function.ref for function in trace.functions])
    _check_profile(profile or {}, list(names.values()))
    blocks = {}
    exposures = {}
    observed = {}
    for function in trace.functions:
        visits = [visit for visit in trace.visits if visit.function == function.ref]
        here = [each for each in bound if _is_active(each, visits, active)]
        following = computed_next(counts[function.ref])
        name = names[function.ref]
        if profile and name in profile:
            following = _pinned(profile[name], following.text, name)
        blocks[function.ref] = RiskBlock(
            name=function.ref.name,
            call_sequence=computed_count(function.call_sequence),
            next=following,
            components=tuple(_entry(each, visits, active) for each in here),
        )
        exposures[function.ref] = {
            each.component.name: seconds
            for each in here
            if (seconds := _mean_exposure(each, visits, active)) is not None
        }
        observed[function.ref] = tuple(
            each.component.name for each in here if not each.component.always_active
        )
    return ComputedBlocks(blocks, exposures, observed, _assumptions(bound))


def next_counts(trace: Trace) -> dict[FunctionRef, dict[str, int]]:
    """Return how many visits of each target followed the visits of each function.

    Targets stand in the order of their call sequence, `done` last, and are called as in the
    model.
    """
    names = model_names([function.ref for function in trace.functions])
    counts: dict[FunctionRef, dict[str, int]] = {}
    for function in trace.functions:
        counts[function.ref] = dict.fromkeys((*names.values(), DONE), 0)
    if trace.cycle is not None:
        return _cycled_counts(trace, trace.cycle, counts, names)
    followers = [names[visit.function] for visit in trace.visits[1:]] + [DONE]
    for visit, follower in zip(trace.visits, followers, strict=True):
        counts[visit.function][follower] += 1
    return _without_zeros(counts)


def _cycled_counts(
    trace: Trace,
    cycle: Cycle,
    counts: dict[FunctionRef, dict[str, int]],
    names: Mapping[FunctionRef, str],
) -> dict[FunctionRef, dict[str, int]]:
    """Count as if the cycle had come as often as the mission is declared to have it."""
    path = [visit.function for visit in trace.visits[: cycle.first_visit + cycle.visits]]
    for number, (function, follower) in enumerate(itertools.pairwise(path), start=1):
        is_in_cycle = number > cycle.first_visit
        counts[function][names[follower]] += cycle.mission_cycles if is_in_cycle else 1
    counts[path[-1]][names[path[cycle.first_visit]]] += cycle.mission_cycles - 1
    counts[path[-1]][DONE] += 1
    return _without_zeros(counts)


def _without_zeros(
    counts: Mapping[FunctionRef, Mapping[str, int]],
) -> dict[FunctionRef, dict[str, int]]:
    return {
        ref: {target: count for target, count in row.items() if count}
        for ref, row in counts.items()
    }


def _check_profile(profile: ProfileText, names: Sequence[str]) -> None:
    for name, shares in profile.items():
        if name not in names:
            raise InputError(f"profile: no function '{name}' in the trace; {one_of(names, name)}")
        for target in shares:
            if target not in (*names, DONE):
                raise InputError(
                    f"profile of '{name}': no function '{target}' in the trace; "
                    f"{one_of((*names, DONE), target)}"
                )


def _pinned(shares: Mapping[str, str], computed: str, name: str) -> Field[tuple[Transition, ...]]:
    try:
        return profile_next(shares, computed)
    except ValueError as error:
        raise InputError(f"profile of '{name}': expected {error}") from error


def _is_active(bound: BoundComponent, visits: Sequence[Visit], mode: ActiveMode) -> bool:
    if bound.component.always_active:
        return True
    return any(_is_active_in(bound, visit, mode) for visit in visits)


def _is_active_in(bound: BoundComponent, visit: Visit, mode: ActiveMode) -> bool:
    for element in bound.elements:
        if element not in visit.exposures:
            continue
        exposure = visit.exposures[element]
        if exposure is None:
            return True
        longest = exposure.longest_moving_s if mode == "moving" else exposure.longest_active_s
        if longest >= SHORTEST_ACTIVITY_S:
            return True
    return False


def _seconds(exposure: Exposure, mode: ActiveMode) -> float:
    return exposure.moving_s if mode == "moving" else exposure.active_s


def _uses(bound: BoundComponent, visit: Visit, mode: ActiveMode) -> list[Use]:
    """Return the use of each unit during one visit."""
    if bound.component.always_active:
        return [Use(visit.duration_s, None)] * bound.quantity
    uses = []
    for element in bound.units():
        exposure = visit.exposures.get(element, Exposure())
        if exposure is None:
            uses.append(Use(None, None))
        else:
            demands = max(exposure.starts, exposure.grasps)
            uses.append(Use(_seconds(exposure, mode), demands))
    return uses


def _entry(bound: BoundComponent, visits: Sequence[Visit], mode: ActiveMode) -> ComponentEntry:
    component = bound.component
    per_visit = tuple(f for f in component.figures if f.per is Basis.VISIT)
    by_use = tuple(f for f in component.figures if f.per is not Basis.VISIT)
    units = []
    for visit in visits:
        counted = by_use
        if component.always_active or _is_active_in(bound, visit, mode):
            # The published reading: one figure for each visit in which the component is active.
            counted = (*by_use, *per_visit)
        try:
            units.append([unit_probability(counted, use) for use in _uses(bound, visit, mode)])
        except ValueError as error:
            raise HardwareError(
                f"component '{component.name}': {error} from this trace; "
                "give its figure 'per: visit', or use a trace of the twin",
                component.location,
            ) from error
    probability = group_unit_probability(units, component.redundancy)
    return ComponentEntry(
        name=component.name,
        probability=computed_probability(probability),
        quantity=computed_count(bound.quantity),
        redundancy=computed_redundancy(component.redundancy),
    )


def _mean_exposure(
    bound: BoundComponent, visits: Sequence[Visit], mode: ActiveMode
) -> float | None:
    seconds = [use.exposure_s for visit in visits for use in _uses(bound, visit, mode)]
    known = [each for each in seconds if each is not None]
    return sum(known) / bound.quantity if len(known) == len(seconds) else None


def _check_tests(bound: Sequence[BoundComponent], trace: Trace) -> None:
    """Raise HardwareError where what is tested may be failed when a mission starts."""
    for each in bound:
        component = each.component
        if component.test_interval_s is None:
            continue
        mission_s = _mission_time(trace)
        if mission_s is None:
            found = "the time of a mission, which this trace does not tell"
        elif component.test_interval_s > mission_s:
            found = f"the mission of {mission_s:.4g} s"
        else:
            continue
        raise HardwareError(
            f"component '{component.name}': its test interval of {component.test_interval_s:.4g} s "
            f"is longer than {found}: a failure hidden in an earlier mission could still be "
            "there, which is not computed; test the group before each mission and write "
            "'detected: mission_start'",
            component.location,
        )


def _mission_time(trace: Trace) -> float | None:
    """Return the time of a mission [s], each visit of a cycle counted as often as it comes."""
    total = 0.0
    for number, visit in enumerate(trace.visits):
        if visit.duration_s is None:
            return None
        times = 1
        if trace.cycle is not None:
            first, length = trace.cycle.first_visit, trace.cycle.visits
            if number >= first + length:
                break
            times = trace.cycle.mission_cycles if number >= first else 1
        total += times * visit.duration_s
    return total


def _assumptions(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    return (*_per_visit(bound), *_tested(bound))


def _tested(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    names = sorted(
        each.component.name for each in bound if each.component.test_interval_s is not None
    )
    if not names:
        return ()
    return (
        f"{', '.join(names)}: tests within the mission are not counted: a failure is taken to "
        "stay hidden until the mission ends, which overstates the risk",
    )


def _per_visit(bound: Sequence[BoundComponent]) -> tuple[str, ...]:
    per_visit = sorted(
        each.component.name
        for each in bound
        if any(figure.per is Basis.VISIT for figure in each.component.figures)
    )
    if not per_visit:
        return ()
    return (
        f"{', '.join(per_visit)}: failure figures are per visit, whatever its length, so the "
        "mission's figure depends on how the code is cut into functions",
    )
