"""A whole mission as one fault tree, which tools solve that know no chain.

It is the mission as executed: each function is visited as often as is expected where nothing
fails. What is repaired or renewed between visits is an event of one function; the units whose
failures stay latent are events of the mission, failing over all visits together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

from tracerisk.prm.hybrid.elements import DONE, FunctionState
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate

TOP = "mission fails"


@dataclass(frozen=True, slots=True)
class RenewedPart:
    """What is as good as new at each visit: a component of a function, or a common cause of it."""

    function: str
    """Name of the function."""
    part: str
    """Name of its gate or event in the function's fault tree."""
    visits: Fraction
    """Expected visits of the function where nothing fails, N."""
    per_visit: float
    """Failure probability in one visit, p."""
    per_mission: float
    """Failure probability over all visits, 1 - (1 - p)^N."""

    @property
    def event(self) -> str:
        """Its name in the mission's fault tree."""
        return f"{self.function}: {self.part}"


@dataclass(frozen=True, slots=True)
class LatentUnit:
    """A unit whose failure stays hidden until the mission ends."""

    name: str
    """Name of its event in the fault trees of functions."""
    per_visit: Mapping[str, float]
    """Failure probability in a visit of each function that uses it, by function."""
    per_mission: float
    """Failure probability over all visits, 1 - prod (1 - p_f)^(N_f)."""


@dataclass(frozen=True, slots=True)
class LatentGroup:
    """Redundant units, as the mission has them."""

    component: str
    """Name of the component."""
    units: tuple[LatentUnit, ...]
    """Its units, in their order."""
    least: int
    """Number of failed units at which the group fails; the least that any function tolerates."""
    per_mission: float
    """Failure probability of the group over all visits."""


@dataclass(frozen=True, slots=True)
class MissionTree:
    """A mission as one fault tree, and the parts that it is made of."""

    visits: Mapping[str, Fraction]
    """Expected visits of each function where nothing fails, by its name."""
    renewed: tuple[RenewedPart, ...]
    """Parts that are renewed at each visit, in the order of functions and components."""
    groups: tuple[LatentGroup, ...]
    """Groups with latent failures, in the order of their first use."""
    tree: FaultTree
    """The tree."""
    figures: Mapping[str, float]
    """The probability of each of its basic events."""
    probability: float
    """Probability of its top event."""


def mission_tree(model: HybridModel) -> MissionTree | None:
    """Return the mission of a model as one fault tree; `None` where no tree holds it.

    A spare fails at another rate once it works, so that no static tree holds one; and a model in
    which nothing can fail has no events.
    """
    if any(state.spares for state in model.states):
        return None
    visits = visits_without_failure(model)
    renewed: list[RenewedPart] = []
    gates: dict[str, list[tuple[FunctionState, Gate]]] = {}
    for state in model.states:
        if state.tree.events and visits[state.name]:
            renewed += _renewed(state, visits[state.name], model.latent, gates)
    groups = tuple(_group(name, uses, visits) for name, uses in gates.items())
    formulas: dict[str, tuple[str | int, ...]] = {}
    figures = {part.event: part.per_mission for part in renewed}
    for group in groups:
        names = [unit.name for unit in group.units]
        formulas[group.component] = ("atleast", group.least, *names)
        figures |= {unit.name: unit.per_mission for unit in group.units}
    inputs = [*(part.event for part in renewed), *formulas]
    if not inputs:
        return None
    tree = FaultTree.of(TOP, {TOP: ("or", *inputs), **formulas}, figures)
    return MissionTree(visits, tuple(renewed), groups, tree, figures, tree.probability(figures).p)


def visits_without_failure(model: HybridModel) -> dict[str, Fraction]:
    """Return how often a mission visits each function where nothing fails, exactly.

    N_entry = 1 + sum of what comes back, N_f = sum over g of N_g next(g, f): linear equations,
    eliminated one function after the other.
    """
    names = [state.name for state in model.states]
    rows = {name: {name: Fraction(1)} for name in names}
    right = {name: Fraction(int(name == model.entry)) for name in names}
    for state in model.states:
        for step in state.next:
            if step.target != DONE:
                row = rows[step.target]
                row[state.name] = row.get(state.name, Fraction(0)) - step.weight
    reachable = set(model.reachable)
    order = [name for name in names if name in reachable]
    for number, pivot in enumerate(order):
        for name in order[number + 1 :]:
            factor = rows[name].pop(pivot, Fraction(0)) / rows[pivot][pivot]
            if factor:
                for other, value in rows[pivot].items():
                    if other != pivot:
                        rows[name][other] = rows[name].get(other, Fraction(0)) - factor * value
                right[name] -= factor * right[pivot]
    visits = dict.fromkeys(names, Fraction(0))
    for name in reversed(order):
        rest = sum(value * visits[other] for other, value in rows[name].items() if other != name)
        visits[name] = (right[name] - rest) / rows[name][name]
    return visits


def _renewed(
    state: FunctionState,
    visits: Fraction,
    latent: tuple[str, ...],
    gates: dict[str, list[tuple[FunctionState, Gate]]],
) -> Iterator[RenewedPart]:
    """Yield the renewed parts of a function; put its gates of latent units into `gates`."""
    of_name = {gate.name: gate for gate in state.tree.gates}
    fails = state.tree.node_probabilities(state.probabilities)
    left = list(of_name[state.tree.top].inputs)
    for name in left:
        gate = of_name.get(name)
        if gate is not None and any(part in of_name for part in gate.inputs):
            # A gate of the units apart, and their common cause beside it.
            left.extend(gate.inputs)
        elif gate is not None and set(gate.inputs) <= set(latent):
            component = next(
                event.component for event in state.tree.events if event.name in gate.inputs
            )
            gates.setdefault(component, []).append((state, gate))
        else:
            p = fails[name].p
            yield RenewedPart(state.name, name, visits, p, _over([(visits, p)]))


def _group(
    component: str, uses: list[tuple[FunctionState, Gate]], visits: Mapping[str, Fraction]
) -> LatentGroup:
    units: dict[str, dict[str, float]] = {}
    for state, gate in uses:
        parameters = {event.name: event.parameter for event in state.tree.events}
        for name in gate.inputs:
            p = state.probabilities[parameters[name]]
            units.setdefault(name, {})[state.name] = p
    latent = tuple(
        LatentUnit(name, by_state, _over([(visits[f], p) for f, p in by_state.items()]))
        for name, by_state in units.items()
    )
    least = min(gate.threshold for _, gate in uses)
    figures = {unit.name: unit.per_mission for unit in latent}
    tree = FaultTree.of(component, {component: ("atleast", least, *figures)}, figures)
    return LatentGroup(component, latent, least, tree.probability(figures).p)


def _over(counts: list[tuple[Fraction, float]]) -> float:
    """Return 1 - prod (1 - p)^N over pairs (N, p)."""
    if any(p >= 1.0 and n > 0 for n, p in counts):
        return 1.0
    return 0.0 - math.expm1(math.fsum(float(n) * math.log1p(-p) for n, p in counts))
