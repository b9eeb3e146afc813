"""Dynamic trees from plain Python values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.other_models.dynamic.elements import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.trees.events import FailureModel
from tracerisk.prm.trees.failure_models import Constant
from tracerisk.prm.trees.gates import Gate, GateKind

Formula = Sequence[str | int | float]
"""A kind, its number if it has one, and its inputs: `("spare", "a", "b")`."""

_STATIC = {kind.value: kind for kind in GateKind if kind is not GateKind.CARDINALITY}
_DYNAMIC = {kind.value: kind for kind in DynamicKind}
_RESTRICTIONS = {kind.value: kind for kind in RestrictionKind}
_KINDS = {*_STATIC, *_DYNAMIC, *_RESTRICTIONS, "fdep", "pdep"}
_NUMBERED = {"atleast", "pdep"}


def tree_parts(
    formulas: Mapping[str, Formula],
    events: Mapping[str, float | FailureModel | DynamicEvent],
) -> tuple[
    tuple[Gate | DynamicGate, ...],
    tuple[DynamicEvent, ...],
    tuple[Dependency, ...],
    tuple[Restriction, ...],
]:
    """Return the gates, events, dependencies and restrictions of formulas; see DynamicTree.of."""
    gates: list[Gate | DynamicGate] = []
    dependencies: list[Dependency] = []
    restrictions: list[Restriction] = []
    for name, formula in formulas.items():
        kind, number, inputs = _parts(name, formula)
        if kind in ("fdep", "pdep"):
            if not inputs:
                raise ModelError(f"'{name}': {kind} needs a trigger and its dependents")
            probability = 1.0 if number is None else float(number)
            dependencies.append(Dependency(name, inputs[0], inputs[1:], probability))
        elif kind in _RESTRICTIONS:
            restrictions.append(Restriction(name, _RESTRICTIONS[kind], inputs))
        elif kind in _DYNAMIC:
            gates.append(DynamicGate(name, _DYNAMIC[kind], inputs))
        else:
            gates.append(Gate(name, _STATIC[kind], inputs, None if number is None else int(number)))
    return (
        tuple(gates),
        tuple(_event(name, figure) for name, figure in events.items()),
        tuple(dependencies),
        tuple(restrictions),
    )


def _parts(name: str, formula: Formula) -> tuple[str, int | float | None, tuple[str, ...]]:
    """Return the kind, the number and the inputs of a formula."""
    if isinstance(formula, str) or not formula or not isinstance(formula[0], str):
        raise ModelError(
            f"'{name}': {formula!r} is not a formula; give its kind and inputs, as in "
            "('spare', 'a', 'b')"
        )
    kind, rest = formula[0], list(formula[1:])
    if kind not in _KINDS:
        raise ModelError(f"'{name}': '{kind}' is not a kind of gate; {one_of(_KINDS, kind)}")
    number = None
    if kind in _NUMBERED:
        if not rest or isinstance(rest[0], str):
            raise ModelError(f"'{name}': {kind} needs a number before its inputs")
        first = rest.pop(0)
        number = None if isinstance(first, str) else first
    inputs = [part for part in rest if isinstance(part, str)]
    if len(inputs) < len(rest):
        raise ModelError(f"'{name}': {rest!r} contains an input that is not a name; give names")
    return kind, number, tuple(inputs)


def _event(name: str, figure: float | FailureModel | DynamicEvent) -> DynamicEvent:
    if isinstance(figure, DynamicEvent):
        if figure.name != name:
            raise ModelError(f"event '{name}' is given as '{figure.name}'; give it one name")
        return figure
    if isinstance(figure, int | float):
        try:
            return DynamicEvent(name, Constant(float(figure)))
        except ModelError as error:
            raise ModelError(f"event '{name}': {error.message}") from error
    return DynamicEvent(name, figure)
