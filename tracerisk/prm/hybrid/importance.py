"""Importance over the mission of every parameter, from one forward and one backward pass.

Theta is common to all states, visits and units; with v the expected visits of the chain, hidden
states included, and F the mission's failure probability:

    dF/dtheta = sum_i v_i sum_j (-dP_ij/dtheta) w_j,   F - F0 = sum_i v0_i sum_j (P0_ij - P_ij) w_j

w the success from a state, 0 for theta = 0 (own derivation: subtract the first-step equations of
the two chains and solve for the difference). Both are sums of positive terms, see `adjoint`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from tracerisk.prm.hybrid.adjoint import Adjoint, Slopes
from tracerisk.prm.hybrid.assessment import ComponentImportance, ImportanceShare
from tracerisk.prm.hybrid.chain_solver import SolvedMission
from tracerisk.prm.hybrid.elements import Parameter
from tracerisk.prm.hybrid.fixed_cycles import failure_of
from tracerisk.prm.hybrid.hidden.hidden_chain import Flow, HiddenChain
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.numbers.probability import worth


def importances(model: HybridModel, solved: SolvedMission) -> tuple[ComponentImportance, ...]:
    """Return the importance of each parameter, that which matters most first."""
    grouped = solved.grouped
    base = _Base(solved.chain, solved.flow)
    if grouped is None:
        result = [
            _ranked(parameter, *_effect(base, parameter), base.failure, base.held)
            for parameter in model.parameters
        ]
    else:
        own = [_Base(*flow) for flow in zip(grouped.own, grouped.own_flows, strict=True)]
        failure, result = solved.failure.p, []
        for parameter in model.parameters:
            parts = [own[group] for group in grouped.groups_with.get(parameter.name, ())]
            result.append(
                _ranked(
                    parameter, *_sum_of_groups(failure, base, parts, parameter), failure, failure
                )
            )
    return tuple(sorted(result, key=lambda i: (-i.fussell_vesely, -i.criticality, i.name)))


class _Base:
    """The model as it is: its mission, and what that depends on."""

    def __init__(self, chain: HiddenChain, flow: Flow) -> None:
        self.chain = chain
        self.adjoint = Adjoint(chain)
        self.slopes = Slopes(chain, flow, self.adjoint)
        self.failure = failure_of(flow)
        self.held = held_failure(chain, flow)
        self.visits = flow.visits[0]
        states = chain.states
        self.is_plain = states.most is None and not any(f.parts for f in states.functions)

    @cached_property
    def returns(self) -> list[float]:
        """How often each function is visited from a visit of it on, itself included."""
        return self.chain.returns()

    def rise(self, number: int, by: float) -> float | None:
        """Return by how much F rises where a function's visits fail with a probability `by` higher.

        With n visits from one on, of which (n-1) / q follow a visit that is survived, the visits
        v become v / (1 + by (n-1) / q), and each costs `by` of the success that follows it.
        A negative `by` gives a fall; `None` where a difference would cost digits.
        """
        if by == 0.0:
            return 0.0
        q = self.chain.rest[number].q
        if abs(by) > 2.0 * q:
            return None
        more = by * (self.returns[number] - 1.0) / q
        if more < -0.5:
            return None
        cost = self.adjoint.success_after(((0, 1.0),), number)
        return by * cost * self.visits[number] / (1.0 + more)


class _Change(NamedTuple):
    """The mission's failure probability F under changes of one parameter."""

    fall: float
    """F less F without the parameter."""
    left: float
    """F with the parameter at 0."""
    tenfold: float
    """F with ten times the parameter, at most 1."""
    surely: float
    """F with the parameter at 1."""


def held_failure(chain: HiddenChain, flow: Flow) -> float:
    """Return the mission's failure where more failed units than the states hold fail it."""
    failed = [math.fsum(row) for row in flow.failures[:-1]]
    if chain.states.most is not None:
        failed += [
            count * chain.rest[number].q * chain.exceeding(number, layer)
            for layer, row in enumerate(flow.visits[:-1])
            for number, count in enumerate(row)
        ]
    return math.fsum(failed)


_Slopes = list[tuple[str, str, float]]
"""dF/dtheta by state and unit."""


def _effect(base: _Base, parameter: Parameter) -> tuple[_Slopes, _Change]:
    return base.slopes.of(parameter), _change(base, parameter.name)


def _sum_of_groups(
    failure: float, base: _Base, own: Sequence[_Base], parameter: Parameter
) -> tuple[_Slopes, _Change]:
    """Return what a parameter does by each of its groups alone, and by the rest of the trees.

    `base` is the mission without groups, `own` with each group of the parameter by itself. What
    the rest of the trees does is in each of these, and counts once.
    """
    slopes, plain = _effect(base, parameter)
    effects = [_effect(item, parameter) for item in own]
    if effects:
        summed: dict[tuple[str, str], list[float]] = {}
        for effect, _ in effects:
            for state, unit, slope in effect:
                summed.setdefault((state, unit), []).append(slope)
        for state, unit, slope in slopes:
            summed[state, unit].append(-(len(own) - 1) * slope)
        slopes = [(*key, max(0.0, math.fsum(parts))) for key, parts in summed.items()]

    def added(rest: float, groups: list[float]) -> float:
        return math.fsum([rest, *(group - rest for group in groups)]) if groups else rest

    now = added(base.failure, [item.failure for item in own])
    others = max(0.0, failure - now)
    changes = [change for _, change in effects]
    return slopes, _Change(
        fall=max(0.0, min(failure, added(plain.fall, [item.fall for item in changes]))),
        left=max(0.0, added(plain.left, [item.left for item in changes])) + others,
        tenfold=min(1.0, added(plain.tenfold, [item.tenfold for item in changes]) + others),
        surely=min(1.0, added(plain.surely, [item.surely for item in changes]) + others),
    )


def _ranked(
    parameter: Parameter, slopes: _Slopes, change: _Change, failure: float, held: float
) -> ComponentImportance:
    birnbaum = math.fsum(slope for _, _, slope in slopes)
    by_state: dict[str, float] = {}
    by_unit: dict[str, float] = {}
    for state, unit, slope in slopes:
        by_state[state] = by_state.get(state, 0.0) + slope
        by_unit[unit] = by_unit.get(unit, 0.0) + slope
    scale = parameter.theta / held if held > 0.0 else 0.0
    return ComponentImportance(
        component=parameter.component,
        name=parameter.name,
        theta=parameter.theta,
        birnbaum=birnbaum,
        criticality=birnbaum * scale,
        fussell_vesely=change.fall / held if held > 0.0 else 0.0,
        without=change.left,
        risk_reduction_worth=worth(failure, change.left),
        risk_achievement_worth=worth(change.surely, failure),
        tenfold=worth(change.tenfold, failure),
        by_state=_shares(by_state, scale),
        by_unit=_shares(by_unit, scale),
    )


def _change(base: _Base, name: str) -> _Change:
    numbers = base.chain.states.functions_with.get(name, ())
    change = _change_in_one(base, name, numbers) if base.is_plain and len(numbers) < 2 else None
    if change is not None:
        return change
    without = HiddenChain(base.chain.states, {name: 0.0}, base=base.chain)
    flow = without.flow()
    return _Change(
        fall=base.adjoint.fall((name,), without, flow),
        left=failure_of(flow),
        tenfold=_failure_at(base, name, 10.0),
        surely=_failure_at(base, name, math.inf),
    )


def _change_in_one(base: _Base, name: str, numbers: Sequence[int]) -> _Change | None:
    """Return the change for a parameter of one function at most, without solving the chain anew.

    `None` where a figure would lose digits.
    """
    if not numbers:
        return _Change(0.0, base.failure, base.failure, base.failure)
    chain, number = base.chain, numbers[0]
    now = chain.rest[number]
    p = chain.values[number][name]
    rises = [base.rise(number, -chain.trees.drop(number, name))]
    for factor in (10.0, math.inf):
        then = chain.trees.failure_at(
            number, name, 1.0 if factor == math.inf else min(1.0, factor * p)
        )
        rises.append(base.rise(number, then.p - now.p if now.p < 0.5 else now.q - then.q))
    known = [rise for rise in rises if rise is not None and rise >= -base.failure / 4.0]
    if len(known) < len(rises):
        return None
    return _Change(0.0 - known[0], *(base.failure + rise for rise in known))


def _failure_at(base: _Base, name: str, factor: float) -> float:
    return failure_of(HiddenChain(base.chain.states, {name: factor}, base=base.chain).flow())


def _shares(parts: dict[str, float], scale: float) -> tuple[ImportanceShare, ...]:
    return tuple(ImportanceShare(name, part, part * scale) for name, part in parts.items())
