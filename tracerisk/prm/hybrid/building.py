"""Hybrid models from plain Python values: trees, what follows each state, and figures."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.hybrid.elements import DONE, FunctionState, NextStep, Parameter
from tracerisk.prm.numbers.quantities import check_parameters
from tracerisk.prm.trees.failure_models import Constant
from tracerisk.prm.trees.fault_tree import FaultTree

Following: TypeAlias = "str | Mapping[str, float | Fraction]"
"""What follows a state: one, or several with their shares."""

_TOLERANCE = 1e-9


def state_parts(
    name: str,
    trees: Mapping[str, FaultTree],
    following: Mapping[str, Following] | None,
    values: Mapping[str, float],
    visit_h: float | Mapping[str, float] | None,
) -> tuple[tuple[FunctionState, ...], tuple[Parameter, ...]]:
    """Return the states and parameters of fault trees; see HybridModel.of."""
    if not trees:
        raise ModelError(f"model '{name}': no states; give a fault tree for each state")
    names = list(trees)
    if following is None:
        following = dict(zip(names, [*names[1:], DONE], strict=True))
    for state in following:
        if state not in trees:
            raise ModelError(
                f"'next' is given for '{state}', which is not a state; {one_of(trees, state)}"
            )
    hours_of = visit_h if isinstance(visit_h, Mapping) else {}
    for state in hours_of:
        if state not in trees:
            raise ModelError(
                f"visit_h is given for '{state}', which is not a state; {one_of(trees, state)}"
            )
    known = {parameter for tree in trees.values() for parameter in tree.parameters}
    check_parameters(values, known)
    states = []
    theta: dict[str, float] = {}
    events = {event.parameter: event for tree in trees.values() for event in tree.events}
    for rank, (state, tree) in enumerate(trees.items(), 1):
        if state not in following:
            raise ModelError(
                f"state '{state}': 'next' is missing; give its successors, or '{DONE}'"
            )
        hours = hours_of.get(state) if isinstance(visit_h, Mapping) else visit_h
        visit_values = _visit_values(state, tree, values, hours)
        for parameter, value in visit_values.items():
            theta[parameter] = max(theta.get(parameter, 0.0), value)
        steps = tuple(
            NextStep(target, share) for target, share in _shares(state, following[state]).items()
        )
        states.append(FunctionState(state, rank, tree, visit_values, steps))
    return (
        tuple(states),
        tuple(
            Parameter(name, value, component=events[name].component, share=events[name].share)
            for name, value in theta.items()
        ),
    )


def _visit_values(
    state: str, tree: FaultTree, values: Mapping[str, float], hours: float | None
) -> dict[str, float]:
    known: dict[str, float] = {}
    if hours is not None:
        known = tree.values_at(hours)
    else:
        for event in tree.events:
            if isinstance(event.model, Constant):
                known[event.parameter] = event.model.p
            elif event.model is not None and event.parameter not in values:
                raise ModelError(
                    f"state '{state}': event '{event.name}' depends on how long a visit is; "
                    "give visit_h, in hours"
                )
    known.update((name, values[name]) for name in tree.parameters if name in values)
    return {name: known[name] for name in tree.parameters if name in known}


def _shares(state: str, given: Following) -> dict[str, Fraction]:
    """Return the fractions of `next`; decimals are read as written, and a rounded sum is one."""
    if isinstance(given, str):
        return {given: Fraction(1)}
    shares = {}
    for target, share in given.items():
        if not math.isfinite(share):
            raise ModelError(f"state '{state}': next '{target}' is {share!r}; give a finite share")
        shares[target] = Fraction(repr(float(share)) if isinstance(share, float) else share)
    total = sum(shares.values(), Fraction(0))
    if total and abs(total - 1) <= _TOLERANCE:
        return {target: share / total for target, share in shares.items()}
    return shares
