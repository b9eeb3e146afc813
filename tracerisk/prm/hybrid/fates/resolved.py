"""A model with what follows its failures as chains that the solver takes as they are.

Each failed unit draws a fate by itself, and of several in one visit the worst decides: undetected,
stopped safely, back to a function, the earliest function first. So a visit fails at least as badly
as a fate with the top event of the same tree, in which each unit fails with its probability times
the share of the fates as bad as that. What is less bad is a way on from a visit that did not fail.
All of it is our own derivation; see docs/theory.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from tracerisk.prm.hybrid.elements import DONE, FunctionState, NextStep
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hidden.rest_trees import tree_probability
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.elimination import Elimination, Pattern
from tracerisk.prm.numbers.probability import total

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Values

_TINY = 1e-300
"""Added to what is divided by where that may be 0."""
_BELOW_ONE = 1.0 - 2.0**-53


@dataclass(frozen=True, slots=True)
class Split:
    """The fates of one parameter in one function, as shares of its failures."""

    undetected: float
    """What nobody notices, or what does harm before the stop; what no fate is known of too."""
    stopped: float
    """What is noticed and stopped safely."""
    back: Mapping[str, float]
    """What leads back, by each function to which any failure of the state does, in their order."""

    @property
    def failing(self) -> float:
        """What fails the mission."""
        return self.undetected + self.stopped


Splits = Mapping[str, Mapping[str, Split]]
"""The fates by state and parameter, of states that have any."""


def has_fates(model: HybridModel) -> bool:
    """Return whether anything is said of what follows a failure."""
    return any(state.fates for state in model.states)


def leads_back(model: HybridModel) -> bool:
    """Return whether a failure may lead back to a function, so that the mission goes on."""
    return any(
        fate.target
        for state in model.states
        for fates in state.fates.values()
        for fate in fates
        if fate.share > 0
    )


def splits_of(model: HybridModel) -> Splits:
    """Return how the failures of each function with fates end.

    A failure that shows in a later function is remembered until the mission visits that; with
    any other failure on the way there, or where the mission ends first, nobody noticed it.
    Raises ModelError when a tree cannot be solved.
    """
    shown = {
        fate.shows_in
        for state in model.states
        for fates in state.fates.values()
        for fate in fates
        if fate.shows_in
    }
    reaching = _reaching(model, sorted(shown)) if shown else {}
    splits: dict[str, dict[str, Split]] = {}
    for state in model.states:
        targets = {fate.target for fates in state.fates.values() for fate in fates}
        ordered = [other.name for other in model.states if other.name in targets]
        for parameter, fates in state.fates.items():
            undetected = [float(1 - sum((fate.share for fate in fates), Fraction(0)))]
            stopped: list[float] = []
            back: dict[str, list[float]] = {name: [] for name in ordered}
            for fate in fates:
                share = float(fate.share)
                if fate.is_undetected:
                    undetected.append(share)
                    continue
                shows, misses = 1.0, 0.0
                if fate.shows_in:
                    shows, misses = reaching[state.name][fate.shows_in]
                undetected.append(share * misses)
                kept = back[fate.target] if fate.target else stopped
                kept.append(share * shows)
            splits.setdefault(state.name, {})[parameter] = Split(
                total(undetected),
                total(stopped),
                {name: total(shares) for name, shares in back.items()},
            )
    return splits


def chain_model(model: HybridModel) -> HybridModel:
    """Return the model whose visits fail where the mission does; itself without ways back.

    With ways back the numbers of cycles are not fixed.
    """
    if not leads_back(model):
        return model
    splits = splits_of(model)
    return replace(
        model,
        states=tuple(_failing_state(state, splits.get(state.name, {})) for state in model.states),
        counted=False,
    )


def undetected_model(model: HybridModel) -> HybridModel:
    """Return the model whose visits fail where nobody notices; a safe stop ends it well."""
    splits = splits_of(model)
    return replace(
        model,
        states=tuple(
            _undetected_state(state, splits.get(state.name, {})) for state in model.states
        ),
        counted=False,
    )


def unstopped_model(model: HybridModel) -> HybridModel:
    """Return the model with undetected failures alone, in which others never happen."""
    scaled = undetected_model(model)
    steps = {state.name: state.next for state in model.states}
    return replace(
        scaled,
        states=tuple(replace(state, next=steps[state.name]) for state in scaled.states),
        counted=model.counted,
    )


def ways_on(
    state: FunctionState,
    splits: Mapping[str, Split],
    values: Mapping[str, Values],
    *,
    stops_end_well: bool,
) -> dict[str, Values]:
    """Return the ways on from a visit that did not fail, but in which units did, by target.

    Each with its probability, given that the visit did not fail; for `stops_end_well` a safe stop
    leads to `done`, else it is a failure.
    """
    units: dict[str, int] = {}
    for event in state.tree.events:
        units[event.parameter] = units.get(event.parameter, 0) + 1
    targets = dict.fromkeys(name for split in splits.values() for name in split.back)
    levels = [*([DONE] if stops_end_well else []), *targets]
    left: Values = 1.0
    ways: dict[str, Values] = {}
    worse = {
        name: split.undetected if stops_end_well else split.failing
        for name, split in splits.items()
    }
    for level in levels:
        log: Values = 0.0
        for name, split in splits.items():
            share = split.stopped if level == DONE else split.back.get(level, 0.0)
            if share > 0.0:
                p, before = values[name], worse[name]
                log = log + units[name] * _log_complement(p * share / (1.0 - p * before + _TINY))
                worse[name] = before + share
        happens, not_so = _of_log(log)
        ways[level] = left * happens
        left = left * not_so
    return ways


def _log_complement(p: Values) -> Values:
    """Return ln(1-p), for 1 that of the double below it."""
    if isinstance(p, float):
        return math.log1p(-min(p, _BELOW_ONE))
    from tracerisk.prm.numbers.arrays import np

    return np.log1p(-np.minimum(p, _BELOW_ONE))


def _of_log(log: Values) -> tuple[Values, Values]:
    """Return a probability and its complement, of which the logarithm is given."""
    if isinstance(log, float):
        return 0.0 - math.expm1(log), math.exp(log)
    from tracerisk.prm.numbers.arrays import np

    return 0.0 - np.expm1(log), np.exp(log)


def _failing_state(state: FunctionState, splits: Mapping[str, Split]) -> FunctionState:
    scaled = {name: split.failing for name, split in splits.items()}
    ways = ways_on(state, splits, state.probabilities, stops_end_well=False)
    return _scaled(state, scaled, ways)


def _undetected_state(state: FunctionState, splits: Mapping[str, Split]) -> FunctionState:
    scaled = {name: split.undetected for name, split in splits.items()}
    ways = ways_on(state, splits, state.probabilities, stops_end_well=True)
    return _scaled(state, scaled, ways)


def _scaled(
    state: FunctionState, shares: Mapping[str, float], ways: Mapping[str, Values]
) -> FunctionState:
    if not shares:
        return state
    probabilities = {
        name: value * min(1.0, shares.get(name, 1.0)) for name, value in state.probabilities.items()
    }
    exact = {target: Fraction(max(0.0, float(way))) for target, way in ways.items()}
    left = max(Fraction(0), 1 - sum(exact.values(), Fraction(0)))
    steps = {step.target: step.weight * left for step in state.next}
    for target, way in exact.items():
        if way > 0:
            steps[target] = steps.get(target, Fraction(0)) + way
    whole = sum(steps.values(), Fraction(0))
    return replace(
        state,
        probabilities=probabilities,
        next=tuple(NextStep(target, weight / whole) for target, weight in steps.items()),
        fates={},
    )


def _reaching(
    model: HybridModel, shown: Sequence[str]
) -> dict[str, dict[str, tuple[float, float]]]:
    """Return for each state and function the probability that a mission gets from one to the other.

    It starts behind a visit of the state; with it stands its complement, that of another failure
    or of the mission's end before. Redundant groups are as good as new.
    """
    names = list(model.reachable)
    number = {name: place for place, name in enumerate(names)}
    states = [state for state in model.states if state.name in number]
    tops = []
    for state in states:
        whole = in_one_visit(state)
        tops.append(tree_probability(state.name, whole.tree, whole.probabilities))
    pattern = Pattern(
        lambda place: f"'{names[place]}'",
        [[number[step.target] for step in state.next if step.target in number] for state in states],
    )
    reaching: dict[str, dict[str, tuple[float, float]]] = {state.name: {} for state in model.states}
    for target in shown:
        if target not in number:
            for state in model.states:
                reaching[state.name][target] = (0.0, 1.0)
            continue
        rows, hits, misses = [], [], []
        for state, top in zip(states, tops, strict=True):
            row, hit, ends = {}, 0.0, 0.0
            for step in state.next:
                weight = float(step.weight)
                if step.target == target:
                    hit += weight
                elif step.target == DONE:
                    ends += weight
                elif step.target != state.name:
                    row[number[step.target]] = top.q * weight
            rows.append(row)
            hits.append(top.q * hit)
            misses.append(total((top.p, top.q * ends)))
        exits = [hit + miss for hit, miss in zip(hits, misses, strict=True)]
        solved = Elimination(pattern, rows, exits)
        shows, never = solved.right(hits), solved.right(misses)
        for state in states:
            reached, lost = [], []
            for step in state.next:
                weight = float(step.weight)
                if step.target == target:
                    reached.append(weight)
                elif step.target == DONE:
                    lost.append(weight)
                else:
                    reached.append(weight * shows[number[step.target]])
                    lost.append(weight * never[number[step.target]])
            reaching[state.name][target] = (total(reached), total(lost))
        for state in model.states:
            reaching[state.name].setdefault(target, (0.0, 1.0))
    return reaching
