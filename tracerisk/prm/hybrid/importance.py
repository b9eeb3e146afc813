"""Importance over the mission of every parameter, from one forward and one backward pass.

Theta is common to all states, visits and units; with v the expected visits of the chain, hidden
states included, and F the mission's failure probability:

    dF/dtheta = sum_i v_i sum_j (-dP_ij/dtheta) w_j,   F - F0 = sum_i v0_i sum_j (P0_ij - P_ij) w_j

w the success from a state, 0 for theta = 0 (own derivation: subtract the first-step equations of
the two chains and solve for the difference). Both are sums of positive terms, see `adjoint`.
"""

from __future__ import annotations

import math

from tracerisk.prm.hybrid.adjoint import Adjoint
from tracerisk.prm.hybrid.assessment import ComponentImportance, ImportanceShare
from tracerisk.prm.hybrid.hidden_chain import Flow, HiddenChain
from tracerisk.prm.hybrid.hybrid import HybridModel, Parameter
from tracerisk.prm.hybrid.mission import SolvedMission
from tracerisk.prm.hybrid.slopes import Slopes


def importances(model: HybridModel, solved: SolvedMission) -> tuple[ComponentImportance, ...]:
    """Return the importance of each parameter, that which matters most first."""
    base = _Base(solved)
    found = [_importance(base, parameter) for parameter in model.parameters]
    return tuple(sorted(found, key=lambda i: (-i.fussell_vesely, -i.criticality, i.name)))


class _Base:
    """The model as it is: its mission, and what that hangs on."""

    def __init__(self, solved: SolvedMission) -> None:
        self.chain = solved.chain
        self.adjoint = Adjoint(solved.chain)
        self.slopes = Slopes(solved.chain, solved.flow, self.adjoint)
        self.failure = solved.failure.p
        self.held = held_failure(solved.chain, solved.flow)


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
    slopes = base.slopes.of(parameter)
    birnbaum = math.fsum(slope for _, _, slope in slopes)
    by_state: dict[str, float] = {}
    by_unit: dict[str, float] = {}
    for state, unit, slope in slopes:
        by_state[state] = by_state.get(state, 0.0) + slope
        by_unit[unit] = by_unit.get(unit, 0.0) + slope
    without = HiddenChain(states, {name: 0.0}, base=base.chain)
    flow = without.flow()
    left = _failure(flow)
    scale = parameter.theta / base.held if base.held > 0.0 else 0.0
    fall = base.adjoint.fall((name,), without, flow)
    return ComponentImportance(
        name=name,
        theta=parameter.theta,
        birnbaum=birnbaum,
        criticality=birnbaum * scale,
        fussell_vesely=fall / base.held if base.held > 0.0 else 0.0,
        without=left,
        risk_reduction_worth=_ratio(base.failure, left),
        risk_achievement_worth=_ratio(_failure_at(base, name, math.inf), base.failure),
        tenfold=_ratio(_failure_at(base, name, 10.0), base.failure),
        by_state=_shares(by_state, scale),
        by_unit=_shares(by_unit, scale),
    )


def _failure_at(base: _Base, name: str, factor: float) -> float:
    return _failure(HiddenChain(base.chain.states, {name: factor}, base=base.chain).flow())


def _failure(flow: Flow) -> float:
    return math.fsum(math.fsum(row) for row in flow.failures)


def _shares(parts: dict[str, float], scale: float) -> tuple[ImportanceShare, ...]:
    return tuple(ImportanceShare(name, part, part * scale) for name, part in parts.items())


def _ratio(above: float, below: float) -> float:
    if below > 0.0:
        return above / below
    return math.inf if above > 0.0 else 1.0
