"""Models from plain Python values: dictionaries, tuples, numbers and failure models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from numbers import Integral, Number, Real
from typing import TYPE_CHECKING, TypeAlias, TypeGuard

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.quantities import check_parameters
from tracerisk.prm.trees.fault_tree import BasicEvent, FaultTree, HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

if TYPE_CHECKING:
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.prm.trees.fault_tree import FailureModel

Formula: TypeAlias = "Sequence[str | int | Formula]"
"""A kind of gate, its numbers if it has any, and its inputs: `("atleast", 2, "a", "b", "c")`."""
Figure: TypeAlias = "float | FailureModel | None"
"""A probability, a failure model, or nothing: then a value is given when the tree is solved."""
Following: TypeAlias = "str | Mapping[str, float | Fraction]"
"""What follows a state: one, or several with their shares."""

_NUMBERS = {GateKind.ATLEAST: 1, GateKind.CARDINALITY: 2}
_TOLERANCE = 1e-9


def built_tree(
    top: str,
    gates: Mapping[str, Formula],
    events: Mapping[str, Figure | BasicEvent] | None,
    houses: Mapping[str, bool],
) -> FaultTree:
    """Return the fault tree of some formulas; see FaultTree.of."""
    made: dict[str, Gate] = {}
    for name, formula in gates.items():
        _grow(name, formula, made)
    inputs = dict.fromkeys(name for gate in made.values() for name in gate.inputs)
    if events is None:
        known = {*made, *houses}
        events = dict.fromkeys(name for name in (top, *inputs) if name not in known)
    return FaultTree(
        top,
        tuple(made.values()),
        tuple(_event(name, figure) for name, figure in events.items()),
        tuple(_house(name, state) for name, state in houses.items()),
    )


def _grow(name: str, formula: Formula, made: dict[str, Gate]) -> None:
    """Make the gate of a formula, and one for each formula within it."""
    waiting = [(name, formula)]
    while waiting:
        name, formula = waiting.pop()
        if name in made:
            raise ModelError(f"duplicate gate '{name}'; rename it, or the gate of a formula in it")
        kind, numbers, parts = _parted(name, formula)
        inputs: list[str] = []
        within: list[tuple[str, Formula]] = []
        for rank, part in enumerate(parts, 1):
            if isinstance(part, str):
                inputs.append(part)
            elif isinstance(part, int | float | Number):
                raise ModelError(f"gate '{name}': {part!r} is no input; give a name or a formula")
            else:
                inputs.append(f"{name}.{rank}")
                within.append((inputs[-1], part))
        k, most = (*numbers, None, None)[:2]
        made[name] = Gate(name, kind, tuple(inputs), k, most)
        waiting.extend(reversed(within))


def _parted(
    name: str, formula: Formula
) -> tuple[GateKind, list[int], Sequence[str | int | Formula]]:
    """Return a formula's kind of gate, its numbers and its inputs."""
    if (
        not isinstance(formula, Sequence)
        or isinstance(formula, str)
        or not formula
        or not isinstance(formula[0], str)
    ):
        raise ModelError(
            f"gate '{name}': {formula!r} is not a formula; give its kind and inputs, as in "
            "('or', 'a', 'b')"
        )
    kinds = {kind.value: kind for kind in GateKind}
    if formula[0] not in kinds:
        raise ModelError(
            f"gate '{name}': '{formula[0]}' is not a kind of gate; {one_of(kinds, formula[0])}"
        )
    kind = kinds[formula[0]]
    count = _NUMBERS.get(kind, 0)
    given = formula[1 : 1 + count]
    numbers = [int(each) for each in given if _is_whole(each)]
    if len(numbers) < count:
        raise ModelError(
            f"gate '{name}': {kind.value} needs {count} number{'s' * (count > 1)} before its "
            f"inputs; found {given!r}"
        )
    return kind, numbers, formula[1 + count :]


def _is_whole(value: object) -> TypeGuard[int]:
    return isinstance(value, Integral) and not isinstance(value, bool)


def _event(name: str, figure: Figure | BasicEvent) -> BasicEvent:
    if isinstance(figure, BasicEvent):
        if figure.name != name:
            raise ModelError(f"event '{name}' is given as '{figure.name}'; give it one name")
        return figure
    if isinstance(figure, int | float | Real):
        from tracerisk.prm.trees.failure_models import Constant

        try:
            return BasicEvent(name, model=Constant(float(figure)))
        except ModelError as error:
            raise ModelError(f"event '{name}': {error.message}") from error
    model: object = figure
    if model is not None and not hasattr(model, "probability"):
        raise ModelError(
            f"event '{name}': {figure!r} is not a figure; give a probability, failure model or None"
        )
    return BasicEvent(name, model=figure)


def _house(name: str, state: bool) -> HouseEvent:
    if state not in (False, True):
        raise ModelError(f"house event '{name}': state {state!r}; give True or False")
    return HouseEvent(name, bool(state))


def built_hybrid(
    name: str,
    trees: Mapping[str, FaultTree],
    following: Mapping[str, Following] | None,
    values: Mapping[str, float],
    visit_h: float | Mapping[str, float] | None,
    entry: str | None,
    latent: tuple[str, ...],
) -> HybridModel:
    """Return the hybrid model of some fault trees; see HybridModel.of."""
    from tracerisk.prm.hybrid.hybrid import DONE, FunctionState, HybridModel, NextStep, Parameter

    if not trees:
        raise ModelError(f"model '{name}': no state; give a fault tree for each")
    names = list(trees)
    if following is None:
        following = dict(zip(names, [*names[1:], DONE], strict=True))
    for state in following:
        if state not in trees:
            raise ModelError(f"next of '{state}', which is not a state; {one_of(trees, state)}")
    hours_of = visit_h if isinstance(visit_h, Mapping) else {}
    for state in hours_of:
        if state not in trees:
            raise ModelError(f"visit_h of '{state}', which is not a state; {one_of(trees, state)}")
    known = {parameter for tree in trees.values() for parameter in tree.parameters}
    check_parameters(values, known)
    states = []
    theta: dict[str, float] = {}
    for rank, (state, tree) in enumerate(trees.items(), 1):
        if state not in following:
            raise ModelError(f"state '{state}': no next; say what follows it, or '{DONE}'")
        hours = hours_of.get(state) if isinstance(visit_h, Mapping) else visit_h
        found = _visit_values(state, tree, values, hours)
        for parameter, value in found.items():
            theta[parameter] = max(theta.get(parameter, 0.0), value)
        steps = tuple(
            NextStep(target, share) for target, share in _shares(state, following[state]).items()
        )
        states.append(FunctionState(state, rank, tree, found, steps))
    return HybridModel(
        name,
        names[0] if entry is None else entry,
        tuple(states),
        tuple(Parameter(parameter, value) for parameter, value in theta.items()),
        latent,
    )


def _visit_values(
    state: str, tree: FaultTree, values: Mapping[str, float], hours: float | None
) -> dict[str, float]:
    from tracerisk.prm.trees.failure_models import Constant

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
