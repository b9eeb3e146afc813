"""Models from plain Python values: dictionaries, tuples, numbers and failure models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Number, Real
from typing import TYPE_CHECKING, TypeAlias, TypeGuard

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.failure_models import Constant
from tracerisk.prm.trees.gates import Gate, GateKind

if TYPE_CHECKING:
    from tracerisk.prm.trees.events import FailureModel

Formula: TypeAlias = "Sequence[str | int | Formula]"
"""A kind of gate, its numbers if it has any, and its inputs: `("atleast", 2, "a", "b", "c")`."""
Figure: TypeAlias = "float | FailureModel | None"
"""A probability, a failure model, or nothing: then a value is given when the tree is solved."""

_NUMBERS = {GateKind.ATLEAST: 1, GateKind.CARDINALITY: 2}


def tree_parts(
    top: str,
    gates: Mapping[str, Formula],
    events: Mapping[str, Figure | BasicEvent] | None,
    houses: Mapping[str, bool],
) -> tuple[tuple[Gate, ...], tuple[BasicEvent, ...], tuple[HouseEvent, ...]]:
    """Return the gates, basic events and house events of formulas; see FaultTree.of."""
    made: dict[str, Gate] = {}
    for name, formula in gates.items():
        _grow(name, formula, made)
    inputs = dict.fromkeys(name for gate in made.values() for name in gate.inputs)
    if events is None:
        known = {*made, *houses}
        events = dict.fromkeys(name for name in (top, *inputs) if name not in known)
    return (
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
                raise ModelError(
                    f"gate '{name}': {part!r} is not an input; give a name or a formula"
                )
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
    numbers = [int(text) for text in given if _is_whole(text)]
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
