"""Solve a hybrid model: what each function, the mission and each component comes to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from tracerisk.prm.hybrid.assessment import (
    FIXED_CYCLES,
    GEOMETRIC,
    GEOMETRIC_CYCLES,
    HIDDEN_FAILURES,
    RENEWED_REDUNDANCY,
    RENEWED_SPARES,
    Assessment,
    ComponentContribution,
    ComponentImportance,
    MissionFigures,
    StateAssessment,
    bounded,
    grouped,
)
from tracerisk.prm.hybrid.chain_solver import (
    SolvedMission,
    held_bound,
    mission_figures,
    solve_mission,
)
from tracerisk.prm.hybrid.contributions import mean_drops
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.hybrid.fates.resolved import has_fates, undetected_model
from tracerisk.prm.hybrid.function_fault_tree import in_one_visit, is_spare_group
from tracerisk.prm.hybrid.hidden.hidden_states import MOST_STATES
from tracerisk.prm.hybrid.hidden.rest_trees import tree_probability
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.importance import importances
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate


def solve(
    model: HybridModel, *, limit: int = MOST_STATES, with_importances: bool = True
) -> Assessment:
    """Solve the model exactly, to rounding.

    A chain of more than `limit` states, functions times hidden failures, is bounded from above; if
    there are several redundant groups, by solving each of them separately, and an assumption says
    by how much at most. Without importances there are no `components`, in half the time.
    Raises ModelError when a fault tree cannot be solved, or when the chain is left less often
    than the smallest number of double precision.
    """
    solved = solve_mission(model, limit=limit)
    mission = mission_figures(model, solved)
    reached = {function.state.name for function in solved.states.functions}
    return Assessment(
        model=model.name,
        entry=model.entry,
        states=tuple(_state_assessments(model, solved)),
        mission=mission,
        components=importances(model, solved) if with_importances else (),
        assumptions=_assumptions(model, solved, mission),
        findings=tuple(
            f"{state.name} is never reached from {model.entry} and does not contribute to the "
            "mission"
            for state in model.states
            if state.name not in reached
        ),
        undetected_components=_undetected(model, limit) if with_importances else (),
    )


def _undetected(model: HybridModel, limit: int) -> tuple[ComponentImportance, ...]:
    """Return the importances for the undetected failure; none where nothing is known of it."""
    if not has_fates(model):
        return ()
    undetected = undetected_model(model)
    return importances(undetected, solve_mission(undetected, limit=limit))


@dataclass(frozen=True, slots=True)
class ModelFigures:
    """The figures of a model without importances."""

    mission: MissionFigures
    """Failure probability of the mission in each reading."""
    top_events: Mapping[str, float]
    """Probability that one visit fails, by function."""
    expected_visits: Mapping[str, float]
    """Mean number of visits in a mission, by function; 0 where never reached."""


def solve_figures(model: HybridModel) -> ModelFigures:
    """Solve the model for its figures alone, without the importances.

    Raises ModelError as `solve` does.
    """
    solved = solve_mission(model)
    return ModelFigures(
        mission=mission_figures(model, solved),
        top_events={
            state.name: solved.tops[state.name] if state.name in solved.tops else top_event(state).p
            for state in model.states
        },
        expected_visits={state.name: solved.visits.get(state.name, 0.0) for state in model.states},
    )


def top_event(state: FunctionState) -> Probability:
    """Return the probability that one visit to a function fails while no unit has failed before.

    Raises ModelError when its fault tree cannot be solved.
    """
    state = in_one_visit(state)
    return tree_probability(state.name, state.tree, state.probabilities)


def _assumptions(
    model: HybridModel, solved: SolvedMission, mission: MissionFigures
) -> tuple[str, ...]:
    assumptions = []
    gates = [gate for state in model.states for gate in state.tree.gates]
    latent = set(model.latent)
    # A redundant gate without latent units stands for units that are as new at each visit.
    if any(gate.threshold > 1 and not latent.issuperset(gate.inputs) for gate in gates):
        assumptions.append(RENEWED_REDUNDANCY)
    if any(is_spare_group(event) for state in model.states for event in state.tree.events):
        assumptions.append(RENEWED_SPARES)
    if any(function.parts for function in solved.states.functions):
        assumptions.append(HIDDEN_FAILURES)
    if solved.grouped is not None:
        _, bound = held_bound(model, solved)
        assumptions.append(grouped(len(solved.grouped.groups), bound.least, bound.outcome.p))
    elif solved.states.most is not None:
        assumptions.append(bounded(solved.states.most, solved.least, solved.failure.p))
    if model.has_cycle:
        assumptions.append(GEOMETRIC_CYCLES if mission.reading == GEOMETRIC else FIXED_CYCLES)
    return tuple(assumptions)


def _state_assessments(model: HybridModel, solved: SolvedMission) -> list[StateAssessment]:
    number_of = {f.state.name: number for number, f in enumerate(solved.states.functions)}
    failures = model.failure_states
    state_assessments = []
    for state in model.states:
        name, values = state.name, state.probabilities
        if name in number_of:
            top, drops = solved.tops[name], mean_drops(solved, number_of[name])
        else:
            top = top_event(state).p
            drops = _drops(state)
        units = _units(state.tree)
        components = {event.parameter: event.component for event in state.tree.events}
        gates: dict[str, list[Gate]] = {}
        for gate in state.tree.gates:
            for below in gate.inputs:
                gates.setdefault(below, []).append(gate)
        state_assessments.append(
            StateAssessment(
                name=name,
                call_sequence=state.call_sequence,
                failure_state=failures[name],
                top_event=top,
                expected_visits=solved.visits.get(name, 0.0),
                absorption_probability=solved.absorption.get(name, 0.0),
                components=tuple(
                    ComponentContribution(
                        component=components[parameter],
                        name=parameter,
                        units=len(units[parameter]),
                        required=_required(gates, units[parameter]),
                        probability=values[parameter],
                        contribution=drops[parameter],
                    )
                    for parameter in state.tree.parameters
                ),
            )
        )
    return state_assessments


def _drops(state: FunctionState) -> dict[str, float]:
    """Return by how much one visit's top falls without each parameter, no unit failed before."""
    here = in_one_visit(state)
    drops = {}
    for name in state.probabilities:
        without = replace(state, probabilities={**state.probabilities, name: 0.0})
        values = in_one_visit(without).probabilities
        drops[name] = here.tree.difference(here.probabilities, values)
    return drops


def _units(tree: FaultTree) -> dict[str, set[str]]:
    """Return the events of each parameter."""
    units: dict[str, set[str]] = {}
    for event in tree.events:
        units.setdefault(event.parameter, set()).add(event.name)
    return units


def _required(gates: Mapping[str, Sequence[Gate]], units: set[str]) -> int | None:
    """Return how many units of a component must work; `None` where no single gate says so.

    `gates` are those above each event, in the order of the tree.
    """
    if len(units) == 1:
        return 1
    for gate in gates.get(next(iter(units)), ()):
        if units.issubset(gate.inputs):
            alone = len(units) == len(gate.inputs)
            if gate.threshold == 1 or alone:
                return len(units) - gate.threshold + 1
    return None
