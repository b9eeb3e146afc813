"""Importance over the mission of every parameter, from one forward and one backward pass.

Theta is common to all states, visits and units; with v the expected visits of the chain, hidden
states included, and F the mission's failure probability:

    dF/dtheta = sum_i v_i sum_j (-dP_ij/dtheta) w_j,   F - F0 = sum_i v0_i sum_j (P0_ij - P_ij) w_j

w the success from a state, 0 for theta = 0 (own derivation: subtract the first-step equations of
the two chains and solve for the difference). Both are sums of positive terms, see `adjoint`.
"""

from __future__ import annotations

import math

from tracerisk.prm.adjoint import Adjoint
from tracerisk.prm.assessment import ComponentImportance, ImportanceShare
from tracerisk.prm.hidden_chain import Flow, HiddenChain
from tracerisk.prm.hybrid import HybridModel, Parameter
from tracerisk.prm.mission import SolvedMission


def importances(model: HybridModel, solved: SolvedMission) -> tuple[ComponentImportance, ...]:
    """Return the importance of each parameter, that which matters most first."""
    base = _Base(solved)
    found = [_importance(base, parameter) for parameter in model.parameters]
    return tuple(sorted(found, key=lambda i: (-i.fussell_vesely, -i.criticality, i.name)))


class _Base:
    """The model as it is: its mission, the adjoint, the sensitivities of its trees."""

    def __init__(self, solved: SolvedMission) -> None:
        self.solved = solved
        self.chain = solved.chain
        self.adjoint = Adjoint(solved.chain)
        self.total = held_failure(solved.chain, solved.flow)
        functions = self.chain.states.functions
        self.sensitivities = [
            function.rest.sensitivities(values)
            for function, values in zip(functions, self.chain.values, strict=True)
        ]
        # What a function that fails costs the mission, over all of its visits.
        self.cost = [
            math.fsum(
                row[number] * self.adjoint.success_after(self.chain.spread(number, layer), number)
                for layer, row in enumerate(solved.flow.visits[:-1])
                if row[number] > 0.0
            )
            for number in range(len(functions))
        ]


def held_failure(chain: HiddenChain, flow: Flow) -> float:
    """Return the mission's failure where more failed units than the states hold count as one."""
    failed = [math.fsum(row) for row in flow.failures[:-1]]
    if chain.states.most is not None:
        failed += [
            count * chain.rest[number].q * chain.exceeding(number, layer)
            for layer, row in enumerate(flow.visits[:-1])
            for number, count in enumerate(row)
        ]
    return math.fsum(failed)


def _importance(base: _Base, parameter: Parameter) -> ComponentImportance:
    name, states = parameter.name, base.chain.states
    total, failure = base.total, base.solved.failure.p
    slopes = _slopes(base, parameter)
    birnbaum = math.fsum(slope for _, _, slope in slopes)
    by_state: dict[str, float] = {}
    by_unit: dict[str, float] = {}
    for state, unit, slope in slopes:
        by_state[state] = by_state.get(state, 0.0) + slope
        by_unit[unit] = by_unit.get(unit, 0.0) + slope
    without = HiddenChain(states, {name: 0.0}, base=base.chain)
    flow = without.flow()
    left = _failure(flow)
    scale = parameter.theta / total if total > 0.0 else 0.0
    fall = base.adjoint.fall((name,), without, flow)
    return ComponentImportance(
        name=name,
        theta=parameter.theta,
        birnbaum=birnbaum,
        criticality=birnbaum * scale,
        fussell_vesely=fall / total if total > 0.0 else 0.0,
        without=left,
        risk_reduction_worth=ratio(failure, left),
        risk_achievement_worth=ratio(_failure_at(base, name, math.inf), failure),
        tenfold=ratio(_failure_at(base, name, 10.0), failure),
        by_state=_shares(by_state, scale),
        by_unit=_shares(by_unit, scale),
    )


def _slopes(base: _Base, parameter: Parameter) -> list[tuple[str, str, float]]:
    """Return dF/dtheta by state and unit."""
    chain, name = base.chain, parameter.name
    found = []
    for number, function in enumerate(chain.states.functions):
        state = function.state
        if name not in state.probabilities:
            continue
        factor = state.probabilities[name] / parameter.theta if parameter.theta > 0.0 else 1.0
        slopes = {
            event.name: base.cost[number] * base.sensitivities[number][event.name]
            for event in function.rest.events
            if event.parameter == name
        }
        for unit_class, of in function.parameters.items():
            if of == name:
                units = chain.states.classes[unit_class]
                each = _unit_slope(base, number, unit_class) / len(units)
                slopes |= dict.fromkeys(units, each)
        found += [
            (state.name, event.name, factor * slopes[event.name])
            for event in state.tree.events
            if event.name in slopes
        ]
    return found


def _unit_slope(base: _Base, number: int, unit_class: int) -> float:
    """Return what the failure of a latent unit costs, over all visits and working units."""
    working = [
        base.chain.states.working(layer, unit_class)
        for layer in range(len(base.chain.states.hidden))
    ]
    return math.fsum(
        row[number] * units * base.adjoint.unit_loss(number, layer, unit_class)
        for layer, (row, units) in enumerate(
            zip(base.solved.flow.visits[:-1], working, strict=True)
        )
        if row[number] > 0.0 and units > 0
    )


def _failure_at(base: _Base, name: str, factor: float) -> float:
    return _failure(HiddenChain(base.chain.states, {name: factor}, base=base.chain).flow())


def _failure(flow: Flow) -> float:
    return math.fsum(math.fsum(row) for row in flow.failures)


def _shares(parts: dict[str, float], scale: float) -> tuple[ImportanceShare, ...]:
    return tuple(ImportanceShare(name, part, part * scale) for name, part in parts.items())


def ratio(above: float, below: float) -> float:
    """Return a worth: infinite over zero, one for two zeros."""
    if below > 0.0:
        return above / below
    return math.inf if above > 0.0 else 1.0
