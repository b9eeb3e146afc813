"""Solve a hybrid model: what each function, the mission and each component comes to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.assessment import (
    GEOMETRIC_CYCLES,
    RENEWED_REDUNDANCY,
    Assessment,
    ComponentContribution,
    ComponentImportance,
    ImportanceShare,
    MissionFigures,
    StateAssessment,
)
from tracerisk.prm.fault_tree import FaultTree
from tracerisk.prm.hybrid import FunctionState, HybridModel, Parameter
from tracerisk.prm.mission import SolvedMission, mission_figures, solve_mission
from tracerisk.prm.probability import Probability


@dataclass(frozen=True, slots=True)
class _SolvedTree:
    """A state's fault tree: its top, each event's sensitivity, each parameter's share of it."""

    top: Probability
    sensitivities: Mapping[str, float]
    drops: Mapping[str, float]


def solve(model: HybridModel) -> Assessment:
    """Solve the model exactly, to rounding.

    Raises ModelError when a fault tree shares events, or when the chain is left less often
    than the smallest number of double precision.
    """
    trees = {state.name: _solve_tree(state) for state in model.states}
    reached = model.reachable
    live = {name: trees[name].top for name in reached}
    solved = solve_mission(model, live)
    mission = mission_figures(model, live, solved)
    importances = [
        _importance(model, parameter, {name: trees[name] for name in reached}, solved)
        for parameter in model.parameters
    ]
    importances.sort(key=lambda i: (-i.fussell_vesely, -i.criticality, i.name))
    assumptions = []
    if any(gate.threshold > 1 for state in model.states for gate in state.tree.gates):
        assumptions.append(RENEWED_REDUNDANCY)
    if model.has_cycle:
        assumptions.append(GEOMETRIC_CYCLES)
    return Assessment(
        model=model.name,
        entry=model.entry,
        states=tuple(
            _state_assessment(model, state, trees[state.name], solved) for state in model.states
        ),
        mission=mission,
        components=tuple(importances),
        assumptions=tuple(assumptions),
        findings=tuple(
            f"{state.name} is never reached from {model.entry} and adds nothing to the mission"
            for state in model.states
            if state.name not in reached
        ),
    )


@dataclass(frozen=True, slots=True)
class ModelFigures:
    """The mission's figures, and each function's top event and expected visits."""

    mission: MissionFigures
    top_events: Mapping[str, float]
    expected_visits: Mapping[str, float]


def solve_figures(model: HybridModel) -> ModelFigures:
    """Solve the model for its figures alone, without the importances.

    Raises ModelError as `solve` does.
    """
    tops = {state.name: top_event(state) for state in model.states}
    live = {name: tops[name] for name in model.reachable}
    solved = solve_mission(model, live)
    return ModelFigures(
        mission=mission_figures(model, live, solved),
        top_events={name: top.p for name, top in tops.items()},
        expected_visits={name: solved.visits.get(name, 0.0) for name in tops},
    )


def top_event(state: FunctionState) -> Probability:
    """Return the probability that one visit to a function fails, and its complement.

    Raises ModelError when its fault tree shares events.
    """
    return _top(state, state.probabilities)


def _state_assessment(
    model: HybridModel, state: FunctionState, tree: _SolvedTree, solved: SolvedMission
) -> StateAssessment:
    return StateAssessment(
        name=state.name,
        call_sequence=state.call_sequence,
        failure_state=model.failure_states[state.name],
        top_event=tree.top.p,
        expected_visits=solved.visits.get(state.name, 0.0),
        absorption_probability=solved.absorption.get(state.name, 0.0),
        components=tuple(
            ComponentContribution(
                name=name,
                units=sum(event.parameter == name for event in state.tree.events),
                required=_required(state.tree, name),
                probability=state.probabilities[name],
                contribution=tree.drops[name],
            )
            for name in state.tree.parameters
        ),
    )


def _importance(
    model: HybridModel,
    parameter: Parameter,
    trees: Mapping[str, _SolvedTree],
    solved: SolvedMission,
) -> ComponentImportance:
    """Return the importance of one parameter over the mission.

    dF/dtheta = sum_s v_s (sum_j N_sj w_j) dt_s/dtheta, and
    F - F0 = sum_s v_s (t_s - t0_s) sum_j N_sj w0_j, with v the expected visits, N `next`, w the
    probability of success from a state, and 0 for theta = 0 (own derivation: subtract the two
    chains' first-step equations and solve for the difference).
    """
    name = parameter.name
    total = solved.failure.p
    tops = {state: tree.top for state, tree in trees.items()}
    without = solve_mission(model, _tops_with(model, tops, name, 0.0))
    failed = solve_mission(model, _tops_with(model, tops, name, math.inf))
    tenfold = solve_mission(model, _tops_with(model, tops, name, 10.0))
    by_state: dict[str, float] = {}
    by_unit: dict[str, float] = {}
    falls = []
    for state in model.states:
        if name not in state.probabilities or state.name not in trees:
            continue
        visits = solved.visits[state.name]
        factor = state.probabilities[name] / parameter.theta if parameter.theta > 0.0 else 1.0
        weight = visits * _onward(state, solved.done_from) * factor
        tree = trees[state.name]
        parts = {
            event.name: weight * tree.sensitivities[event.name]
            for event in state.tree.events
            if event.parameter == name
        }
        for unit, part in parts.items():
            by_unit[unit] = by_unit.get(unit, 0.0) + part
        by_state[state.name] = math.fsum(parts.values())
        falls.append(visits * tree.drops[name] * _onward(state, without.done_from))
    birnbaum = math.fsum(by_state.values())
    scale = parameter.theta / total if total > 0.0 else 0.0
    return ComponentImportance(
        name=name,
        theta=parameter.theta,
        birnbaum=birnbaum,
        criticality=birnbaum * scale,
        fussell_vesely=math.fsum(falls) / total if total > 0.0 else 0.0,
        without=without.failure.p,
        risk_reduction_worth=_ratio(total, without.failure.p),
        risk_achievement_worth=_ratio(failed.failure.p, total),
        tenfold=_ratio(tenfold.failure.p, total),
        by_state=_shares(by_state, scale),
        by_unit=_shares(by_unit, scale),
    )


def _solve_tree(state: FunctionState) -> _SolvedTree:
    top = _top(state, state.probabilities)
    values = state.probabilities
    drops = {name: state.tree.drop_without(name, values) for name in state.tree.parameters}
    return _SolvedTree(top, state.tree.sensitivities(values), drops)


def _top(state: FunctionState, values: Mapping[str, float]) -> Probability:
    try:
        return state.tree.probability(values)
    except ModelError as error:
        raise ModelError(f"state '{state.name}': {error.message}", error.location) from error


def _tops_with(
    model: HybridModel, tops: Mapping[str, Probability], name: str, factor: float
) -> dict[str, Probability]:
    """Return the tops with one parameter multiplied: 0 never fails, infinity always."""
    changed = dict(tops)
    for state in model.states:
        if state.name in tops and name in state.probabilities:
            value = 1.0 if factor == math.inf else min(1.0, factor * state.probabilities[name])
            changed[state.name] = _top(state, {**state.probabilities, name: value})
    return changed


def _onward(state: FunctionState, done_from: Mapping[str, float]) -> float:
    """Return the probability of success of a mission that has just left `state` unharmed."""
    return math.fsum(
        float(step.weight) * done_from[step.target] for step in state.next if step.weight > 0
    )


def _shares(parts: Mapping[str, float], scale: float) -> tuple[ImportanceShare, ...]:
    return tuple(ImportanceShare(name, part, part * scale) for name, part in parts.items())


def _ratio(above: float, below: float) -> float:
    if below > 0.0:
        return above / below
    return math.inf if above > 0.0 else 1.0


def _required(tree: FaultTree, parameter: str) -> int | None:
    """Return how many units of a component must work; `None` where no single gate says so."""
    units = {event.name for event in tree.events if event.parameter == parameter}
    if len(units) == 1:
        return 1
    for gate in tree.gates:
        if units <= set(gate.inputs):
            alone = len(units) == len(gate.inputs)
            if gate.threshold == 1 or alone:
                return len(units) - gate.threshold + 1
    return None
