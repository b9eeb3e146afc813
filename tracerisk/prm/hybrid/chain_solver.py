"""The chain of a hybrid model solved, and the mission's figures on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

from tracerisk.common.strong_components import joined_parts
from tracerisk.prm.hybrid.assessment import FIXED, GEOMETRIC, MissionFigures, Reading
from tracerisk.prm.hybrid.fates.ends import FatedChain, MissionEnds, Way
from tracerisk.prm.hybrid.fates.resolved import (
    LATE,
    SAFE,
    Shares,
    chain_model,
    has_fates,
    leads_back,
    resolved_shares,
)
from tracerisk.prm.hybrid.fates.undetected import EndingChain, bounding_model
from tracerisk.prm.hybrid.fixed_cycles import (
    Loop,
    Passage,
    counted_passage,
    failure_of,
    outcome_of,
    rounds_of,
)
from tracerisk.prm.hybrid.groups.group_chain import groups_of
from tracerisk.prm.hybrid.groups.grouped import Bound, Grouped
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain, Round
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES, HiddenStates, hidden_states
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.elimination import Elimination
from tracerisk.prm.numbers.probability import Probability, at_least, log_complement, pair_of
from tracerisk.prm.trees.spares import SpareGroup, Spares


@dataclass(frozen=True, slots=True)
class SolvedMission:
    """A model's chain, solved from its entry.

    With `grouped`, `chain` and `flow` leave the redundant groups out, and what a group adds to
    a function is computed separately.
    """

    chain: HiddenChain
    """The chain of functions and hidden states, with its probabilities."""
    flow: Flow
    """Expected visits, failures and ends in `chain` from the entry on."""
    failure: Probability
    """Probability that the mission fails; an upper bound where hidden states are left out."""
    least: float
    """Lower bound of the failure probability, below `failure` where hidden states are left out."""
    visits: Mapping[str, float]
    """Expected visits in a mission, by function."""
    absorption: Mapping[str, float]
    """Probability that the mission ends in the function's failure state, by function."""
    tops: Mapping[str, float]
    """Probability that one visit fails, over the visits of a mission, by function."""
    grouped: Grouped | None = None
    """The redundant groups, solved one by one; `None` where one chain holds all."""
    ends: MissionEnds | None = None
    """How missions end, with all that they remember; `None` where nothing is said of that, or the
    states are too many."""

    @property
    def states(self) -> HiddenStates:
        """The functions and hidden states of the model."""
        return self.chain.states if self.grouped is None else self.grouped.states


def solve_mission(model: HybridModel, *, limit: int = MOST_STATES) -> SolvedMission:
    """Solve the model's chain from its entry, hidden failures included.

    Exact up to `limit` states of the chain, functions times hidden states; else the states with
    the most failed units are taken together and bounded from above, see `HiddenChain`.
    Raises ModelError when a tree cannot be solved or the chain is left too rarely.
    """
    states = hidden_states(chain_model(model), limit)
    if states.most is not None and len(groups_of(states)) > 1:
        return _solved_by_groups(Grouped(states))
    solved = solved_chain(HiddenChain(states))
    return _with_ends(model, solved, limit) if has_fates(model) else solved


def _with_ends(model: HybridModel, solved: SolvedMission, limit: int) -> SolvedMission:
    """Return the mission with its ends, which hold its failure where failures lead back."""
    chain = FatedChain(model, limit)
    if not chain.is_whole:
        return solved
    ends = chain.ends()
    if not leads_back(model):
        return replace(solved, ends=ends)
    failure = Probability(float(ends.failed), float(ends.done))
    scale = failure.p / solved.failure.p if solved.failure.p > 0.0 else 1.0
    return replace(
        solved,
        failure=failure,
        least=failure.p,
        absorption={name: p * scale for name, p in solved.absorption.items()},
        ends=ends,
    )


def solved_chain(chain: HiddenChain) -> SolvedMission:
    """Return the mission of a chain, solved from its entry."""
    flow = chain.flow()
    names = [function.state.name for function in chain.states.functions]
    visits = dict(zip(names, map(math.fsum, zip(*flow.visits, strict=True)), strict=True))
    absorption = dict(zip(names, map(math.fsum, zip(*flow.failures, strict=True)), strict=True))
    return SolvedMission(
        chain=chain,
        flow=flow,
        failure=Probability(math.fsum(absorption.values()), math.fsum(flow.done)),
        least=_least(chain, flow),
        visits=visits,
        absorption=absorption,
        tops={
            name: (
                # Where no unit is latent, the visits are alike.
                absorption[name] / visits[name]
                if chain.states.functions[number].parts and visits[name] > 0.0
                else chain.visit(number, 0).p
            )
            for number, name in enumerate(names)
        },
    )


def _solved_by_groups(grouped: Grouped) -> SolvedMission:
    bound, flow = grouped.geometric(), grouped.flow
    failed = grouped.absorption()
    # Where several groups fail in a mission, the first one ends it: each has its share.
    share = bound.outcome.p / math.fsum(failed) if any(failed) else 1.0
    visits, absorption, tops = {}, {}, {}
    for number, function in enumerate(grouped.states.functions):
        name = function.state.name
        visits[name] = math.fsum(row[number] for row in flow.visits)
        absorption[name] = failed[number] * share
        has_top = function.parts and visits[name] > 0.0
        tops[name] = failed[number] / visits[name] if has_top else grouped.base.rest[number].p
    return SolvedMission(
        grouped.base, flow, bound.outcome, bound.least, visits, absorption, tops, grouped
    )


def mission_figures(model: HybridModel, solved: SolvedMission) -> MissionFigures:
    """Return the mission's failure probability read in three ways, and the one that holds."""
    chain, grouped = solved.chain, solved.grouped
    states = solved.states
    # A way back is taken only where something failed.
    visits = _visits_without_failure(states, hidden_states(model) if leads_back(model) else states)
    whole = Round(states.entry, frozenset(range(len(states.functions))))
    cycles = visits[states.entry]
    reading, mission = held_reading(model, solved)
    if grouped is None:
        cycle = chain.flow(cut=whole)
        one_cycle, all_units = failure_of(cycle), chain
    else:
        one_cycle, all_units = grouped.one_cycle(whole), grouped.all_units()
    if reading == FIXED:
        fixed = mission.p
    elif grouped is not None:
        fixed = _straight(cycles, lambda rounds: grouped.cycles(whole, rounds))
    else:
        fixed = _mean_cycles(chain, cycle, whole, cycles)
    held, of_chain = _ends(model, solved) if has_fates(model) else (_Ends(), _Ends())
    return MissionFigures(
        failure_probability=mission.p,
        done_probability=mission.q,
        reading=reading,
        geometric_cycles=solved.failure.p,
        cycle_failure_probability=one_cycle if model.has_rounds else None,
        expected_cycles=cycles if model.has_rounds else None,
        fixed_cycles=fixed,
        visits_as_run=0.0 - math.expm1(_log_survival_as_run(all_units, visits)),
        undetected_probability=held.undetected,
        undetected_geometric=of_chain.undetected,
        stopped_late_probability=held.stopped_late,
        stopped_late_geometric=of_chain.stopped_late,
        stopped_safely_probability=held.stopped_safely,
        stopped_safely_geometric=of_chain.stopped_safely,
    )


class _Ends(NamedTuple):
    """How likely a mission fails in some ways; `None` where nothing is said of them."""

    undetected: float | None = None
    """Nobody notices, or harm comes before the stop."""
    stopped_late: float | None = None
    """Harm comes before the stop."""
    stopped_safely: float | None = None
    """It stops before any harm."""


def _ends(model: HybridModel, solved: SolvedMission) -> tuple[_Ends, _Ends]:
    """Return the ends in the reading that holds, and those of the chain itself.

    Where hidden states are left out, the undetected failure is a bound from above, and what they
    hold is in no stop; of groups that are solved one by one, stops are those without groups.
    """
    passage, known = _held_passage(model, solved), solved.ends

    @cache
    def shares() -> Shares:
        return resolved_shares(model)

    @cache
    def ending(stop: Way | None = None) -> EndingChain:
        return EndingChain(solved.chain, model, shares(), stop)

    def of(undetected: float, passage: Passage | None) -> _Ends:
        return _Ends(undetected, *(ending(stop).failure(passage) for stop in (LATE, SAFE)))

    if solved.grouped is not None:
        bounding = bounding_model(model)
        groups = solve_mission(bounding)
        unseen = held_reading(bounding, groups)[1].p
        return of(unseen, passage), of(groups.failure.p, None)
    if known is not None:
        ends = (known.undetected, known.stopped_late, known.stopped_safely)
        of_chain = _Ends(*map(float, ends))
    else:
        of_chain = of(ending().failure(None), None)
    if passage is None:
        return of_chain, of_chain
    return of(ending().failure(passage), passage), of_chain


def _held_passage(model: HybridModel, solved: SolvedMission) -> Passage | None:
    """Return what each mission passes, where its numbers of cycles are fixed and there are any."""
    if not model.has_cycle or not model.counted or leads_back(model):
        return None
    return counted_passage(solved.states)


def held_reading(model: HybridModel, solved: SolvedMission) -> tuple[Reading, Probability]:
    """Return the reading that holds for a model, and the outcome of a mission in it."""
    reading, bound = held_bound(model, solved)
    return reading, bound.outcome


def held_bound(model: HybridModel, solved: SolvedMission) -> tuple[Reading, Bound]:
    """Return the reading that holds for a model, and what bounds a mission in it.

    Where hidden states are left out, the lower bound is that of the chain in either reading.
    """
    chain = Bound(solved.failure, solved.least)
    if not model.has_cycle and not leads_back(model):
        return FIXED, chain
    passage = _held_passage(model, solved)
    if passage is None:
        return GEOMETRIC, chain
    if solved.grouped is not None:
        return FIXED, solved.grouped.fixed(passage)
    return FIXED, Bound(outcome_of(solved.chain, passage), solved.least)


def _least(chain: HiddenChain, flow: Flow) -> float:
    """Return the mission's failure with groups that are whole again once too many units fail."""
    held = math.fsum(math.fsum(row) for row in flow.failures[:-1])
    if not any(flow.beyond):
        return held
    tops = [chain.visit(number, 0) for number in range(len(chain.states.functions))]
    visits = _visits(chain.states, tops, flow.beyond)
    return held + math.fsum(count * top.p for count, top in zip(visits, tops, strict=True))


def _visits(
    states: HiddenStates, tops: Sequence[Probability], start: Sequence[float]
) -> list[float]:
    """Return the expected visits of each function, which fails with its top, from a start."""
    rows = [
        {target: top.q * weight for target, weight in function.steps if target != number}
        for number, (function, top) in enumerate(zip(states.functions, tops, strict=True))
    ]
    exits = [
        top.p + top.q * function.done for function, top in zip(states.functions, tops, strict=True)
    ]
    return Elimination(states.pattern, rows, exits).left(start)


def _visits_without_failure(states: HiddenStates, plain: HiddenStates) -> list[float]:
    """Return the expected visits of each function of `states` where nothing fails.

    `plain` are those without ways back; what only these reach is never visited.
    """
    size = len(plain.functions)
    start = [float(number == plain.entry) for number in range(size)]
    counts = _visits(plain, [Probability(0.0, 1.0)] * size, start)
    names = [function.state.name for function in plain.functions]
    visits = dict(zip(names, counts, strict=True))
    return [visits.get(function.state.name, 0.0) for function in states.functions]


def _mean_cycles(chain: HiddenChain, cycle: Flow, whole: Round, cycles: float) -> float:
    """Return the failure probability of so many cycles, one after the other.

    A cycle starts with the units that had failed by the end of the last one. Between whole numbers
    of cycles the logarithm of survival is taken as linear.
    """
    if len(chain.states.hidden) == 1 and chain.states.most is None:
        good = math.fsum((*cycle.done, *cycle.back))
        return 0.0 - math.expm1(cycles * log_complement(Probability(failure_of(cycle), good)))
    rounds = math.floor(cycles + 1e-9)
    part = max(0.0, cycles - rounds)
    now, failed = rounds_of(chain, Loop(whole, rounds, None), [1.0])
    if part <= 1e-9:
        return failed
    after, lost = rounds_of(chain, Loop(whole, 1, None), now)
    logs = [
        log_complement(Probability(failed, math.fsum(now))),
        log_complement(Probability(failed + lost, math.fsum(after))),
    ]
    return -math.expm1((1.0 - part) * logs[0] + part * logs[1])


def _straight(cycles: float, outcome: Callable[[int], Probability]) -> float:
    """Return the failure of so many cycles, the logarithm of survival linear between whole ones.

    `outcome` is that of a whole number of cycles.
    """
    rounds = math.floor(cycles + 1e-9)
    part = max(0.0, cycles - rounds)
    logs = [log_complement(outcome(rounds))]
    if part > 1e-9:
        logs.append(log_complement(outcome(rounds + 1)))
        return 0.0 - math.expm1((1.0 - part) * logs[0] + part * logs[1])
    return 0.0 - math.expm1(logs[0])


def _log_survival_as_run(chain: HiddenChain, visits: Sequence[float]) -> float:
    """Return the logarithm of survival when each function is visited exactly so often.

    Latent units fail over all visits together; of functions that tolerate different numbers of
    the same failed units the strictest decides, and of their spares the least reliable.
    """
    states = chain.states
    total = [count * log_complement(pair) for count, pair in zip(visits, chain.rest, strict=True)]
    survival = [0.0] * len(states.classes)
    for count, units in zip(visits, chain.units, strict=True):
        for number, p in units.items():
            survival[number] += count * log_complement(pair_of(p))
    failed = [Probability(-math.expm1(log), math.exp(log)) for log in survival]
    for classes, threshold in _joined_parts(states):
        group = _joined_spares(states, classes, threshold)
        if group is not None:
            total.append(log_complement(group.visit(failed[classes[0]], 0).pair))
            continue
        units_failed = [failed[c] for c in classes for _ in states.classes[c]]
        total.append(log_complement(at_least(threshold, units_failed)))
    return math.fsum(total)


def _joined_parts(states: HiddenStates) -> list[tuple[tuple[int, ...], int]]:
    """Return the classes that parts of any function join, with the least threshold of these."""
    parts = dict.fromkeys(part for function in states.functions for part in function.parts)
    joined = joined_parts((set(part.classes), [part.threshold]) for part in parts)
    return [(tuple(sorted(classes)), min(thresholds)) for classes, thresholds in joined]


def _joined_spares(
    states: HiddenStates, classes: tuple[int, ...], threshold: int
) -> SpareGroup | None:
    """Return the group with spares that the classes form in every part; else `None`.

    Of parts that differ it has the greatest dormancy and the least reliable switch.
    """
    parts = {part for c in classes for part in states.parts_of[c]}
    groups = [part.spares for part in parts if part.spares is not None]
    if len(groups) < len(parts) or len(classes) > 1:
        return None
    spares = [group.spares for group in groups]
    return SpareGroup(
        groups[0].units,
        groups[0].units - threshold + 1,
        Spares(max(spare.dormancy for spare in spares), max(spare.switch for spare in spares)),
    )
