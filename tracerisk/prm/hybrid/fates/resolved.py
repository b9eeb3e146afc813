"""What follows failures as models that the solver takes as they are.

What a mission remembers until it shows is decided here at once, with the probabilities of what
comes: for importances, fixed cycles, and where there are too many states for `FatedChain`. A visit
fails at least as badly as a fate with the top event of the same tree, in which each unit fails
with its probability times the share of the fates as bad as that. What is less bad is a way on from
a visit that did not fail. All of it is our own derivation; see docs/theory.md.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from tracerisk.prm.hybrid.elements import DONE, FunctionState, NextStep
from tracerisk.prm.hybrid.fates.ends import UNNOTICED, Way, way_shares, ways_on
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit
from tracerisk.prm.hybrid.hidden.rest_trees import tree_probability
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.elimination import Elimination, Pattern
from tracerisk.prm.numbers.probability import total

LATE, SAFE = Way("stopped_late", "", ""), Way("stopped_safely", "", "")
UNDETECTED = (UNNOTICED, LATE)
"""What nobody notices, and what does harm before the stop."""

Shares = Mapping[str, Mapping[str, Mapping[Way, float]]]
"""The share of each way in the failures of a parameter, by state and parameter; none shows later.
"""


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


def resolved_shares(model: HybridModel) -> Shares:
    """Return what follows the failures of each function with fates, all of it at once.

    A failure that shows in a later function is remembered until the mission visits that; with
    any other failure on the way there, or where the mission ends first, nobody noticed it.
    Raises ModelError when a tree cannot be solved.
    """
    shares = way_shares(model)
    shown = {way.shows_in for rows in shares.values() for row in rows.values() for way in row}
    reaching = _reaching(model, sorted(shown - {""})) if shown != {""} else {}
    resolved: dict[str, dict[str, dict[Way, float]]] = {}
    for name, rows in shares.items():
        for parameter, row in rows.items():
            parts: dict[Way, list[float]] = {UNNOTICED: []}
            for way, share in row.items():
                shows, misses = reaching[name][way.shows_in] if way.shows_in else (1.0, 0.0)
                parts[UNNOTICED].append(share * misses)
                parts.setdefault(way._replace(shows_in=""), []).append(share * shows)
            resolved.setdefault(name, {})[parameter] = {
                way: total(values) for way, values in parts.items()
            }
    return resolved


def chain_model(model: HybridModel) -> HybridModel:
    """Return the model whose visits fail where the mission does; itself without ways back.

    With ways back the numbers of cycles are not fixed.
    """
    if not leads_back(model):
        return model
    return replace(failing_model(model, (*UNDETECTED, SAFE)), counted=False)


def undetected_model(model: HybridModel) -> HybridModel:
    """Return the model whose visits fail where nobody notices; a safe stop ends it well."""
    return replace(failing_model(model, UNDETECTED), counted=False)


def failing_model(
    model: HybridModel, failing: Collection[Way], shares: Shares | None = None
) -> HybridModel:
    """Return the model whose visits fail in such ways; other stops end it well.

    `shares` are its resolved ones, where they are known.
    """
    shares = resolved_shares(model) if shares is None else shares
    rank = {state.name: number for number, state in enumerate(model.states)}
    states = []
    for state in model.states:
        rows = shares.get(state.name)
        if rows is None:
            states.append(state)
            continue
        others = {way for row in rows.values() for way in row} - {UNNOTICED, *failing}
        stops = [way for way in (LATE, SAFE) if way in others]
        back = sorted(others - {LATE, SAFE}, key=lambda way: rank[way.target])
        states.append(_failing_state(state, rows, failing, (*stops, *back)))
    return replace(model, states=tuple(states))


def unstopped_model(model: HybridModel) -> HybridModel:
    """Return the model with undetected failures alone, in which others never happen."""
    scaled = undetected_model(model)
    steps = {state.name: state.next for state in model.states}
    return replace(
        scaled,
        states=tuple(replace(state, next=steps[state.name]) for state in scaled.states),
        counted=model.counted,
    )


def _failing_state(
    state: FunctionState,
    rows: Mapping[str, Mapping[Way, float]],
    failing: Collection[Way],
    others: Sequence[Way],
) -> FunctionState:
    worst = {name: total(row.get(way, 0.0) for way in failing) for name, row in rows.items()}
    ways, _ = ways_on(state, others, rows, state.probabilities, worst)
    exact: dict[str, Fraction] = {}
    for way, p in ways.items():
        target = way.target or DONE
        exact[target] = exact.get(target, Fraction(0)) + Fraction(max(0.0, float(p)))
    left = max(Fraction(0), 1 - sum(exact.values(), Fraction(0)))
    steps = {step.target: step.weight * left for step in state.next}
    for target, way_there in exact.items():
        if way_there > 0:
            steps[target] = steps.get(target, Fraction(0)) + way_there
    whole = sum(steps.values(), Fraction(0))
    return replace(
        state,
        probabilities={
            name: value * min(1.0, worst.get(name, 1.0))
            for name, value in state.probabilities.items()
        },
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
    # A mission never comes from one of two functions to the other where either is not reachable.
    reaching = {state.name: dict.fromkeys(shown, (0.0, 1.0)) for state in model.states}
    for target in (name for name in shown if name in number):
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
    return reaching
