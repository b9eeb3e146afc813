"""The places of a group's elements in the rows that are its states, and what each element is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tracerisk.common.strong_components import reached
from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.dynamic.elements import (
    Dependency,
    DynamicEvent,
    DynamicGate,
    DynamicKind,
    Restriction,
    RestrictionKind,
)
from tracerisk.prm.trees.failure_models import GLM, Constant, Erlang, Exponential, PerDemand
from tracerisk.prm.trees.gates import Gate, GateKind

SAFE, FAILED, GONE = 253, 254, 255
"""Never to fail any more; failed; of no account any more. Below them an element can still fail.

Of such an event the byte counts the phases that it has behind it, of a PAND the inputs that failed
in order, of a SPARE it is the position of the input in use.
"""
TAKEN, IN_SERVICE = 1, 2
"""What the byte of a spare says of it."""
LARGEST = 250
START = -1
"""The trigger of what is failed from the start, and waits where that is ruled out then."""

AnyGate = Gate | DynamicGate

_STATIC = (GateKind.OR, GateKind.AND, GateKind.ATLEAST, GateKind.INHIBIT, GateKind.TRANSFER)


@dataclass(frozen=True, slots=True)
class Layout:
    """The elements of a group by place, and their bytes in a state.

    The places are of the events, then of the gates from below upwards. A state has a byte for each
    element, for each dependency and for each spare unit, in this order.
    """

    names: tuple[str, ...]
    """Name of each element, (n_elements,)."""
    top: int
    """Place of the top."""
    events: tuple[DynamicEvent, ...]
    """The events in the order of their places, (n_events,)."""
    gates: Mapping[int, AnyGate]
    """Gate by place."""
    inputs: Mapping[int, tuple[int, ...]]
    """Places of a gate's inputs, by the gate's place."""
    parents: tuple[tuple[int, ...], ...]
    """Places of the gates above each element, (n_elements, n_parents of the element)."""
    dependencies: tuple[tuple[int, tuple[int, ...], float], ...]
    """Dependencies (trigger, dependents, probability), by place; events failed from the start
    have one with the trigger `START` where there are restrictions."""
    restrictions: tuple[tuple[RestrictionKind, tuple[int, ...]], ...]
    """Restrictions (kind, inputs), by place."""
    owner: tuple[int | None, ...]
    """Place of the innermost spare unit that each element is part of, (n_elements,); `None`
    where it is in service from the start."""
    spare_slots: Mapping[int, int]
    """Byte of a spare unit in a state, by the unit's place."""
    rates: tuple[float, ...]
    """Rate of each phase of an event in service [1/h], (n_events,); 0 where it has no rate."""
    phases: tuple[int, ...]
    """Number of phases until an event fails, (n_events,)."""
    starting: Mapping[int, float]
    """Probability of being failed from the start, by place, of events that have no rate."""
    spare_gates: tuple[int, ...]
    """Places of the SPARE gates, from below upwards."""
    parts: Mapping[int, tuple[int, ...]]
    """Places of the elements of each spare unit, by the unit's place."""
    alike: tuple[tuple[int, ...], ...]
    """Groups of places of events that can change places without a difference."""

    @property
    def first_dependency_slot(self) -> int:
        """The byte of the first dependency; the others follow."""
        return len(self.names)

    @property
    def size(self) -> int:
        """The bytes of a state."""
        return len(self.names) + len(self.dependencies) + len(self.spare_slots)


def lay_out(
    top: str,
    gates: Sequence[AnyGate],
    events: Sequence[DynamicEvent],
    dependencies: Sequence[Dependency],
    restrictions: Sequence[Restriction],
) -> Layout:
    """Return the layout of a group whose gates are given from below upwards.

    Raises ModelError when a gate or an event has no meaning in a Markov model, or a spare is part
    of something else too.
    """
    names = (*(event.name for event in events), *(gate.name for gate in gates))
    place = {name: number for number, name in enumerate(names)}
    by_place = {place[gate.name]: gate for gate in gates}
    inputs = {
        number: tuple(place[name] for name in gate.inputs) for number, gate in by_place.items()
    }
    parents: list[list[int]] = [[] for _ in names]
    for number, below in inputs.items():
        for child in dict.fromkeys(below):
            parents[child].append(number)
    for gate in gates:
        _check_gate(gate)
    spares = tuple(number for number, gate in by_place.items() if _is_spare(gate))
    units = tuple(dict.fromkeys(child for gate in spares for child in inputs[gate]))
    rates, phases, starting = _laws(events)
    waiting = [event for event, p in starting.items() if p > 0.0 and restrictions]
    first_unit = len(names) + len(dependencies) + len(waiting)
    owner, parts = _owners(names, inputs, parents, spares, units)
    return Layout(
        names=names,
        top=place[top],
        events=tuple(events),
        gates=by_place,
        inputs=inputs,
        parents=tuple(map(tuple, parents)),
        dependencies=(
            *(
                (place[one.trigger], tuple(place[name] for name in one.dependents), one.probability)
                for one in dependencies
            ),
            *((START, (event,), 1.0) for event in waiting),
        ),
        restrictions=tuple(
            (one.kind, tuple(place[name] for name in one.inputs)) for one in restrictions
        ),
        owner=owner,
        spare_slots={unit: first_unit + number for number, unit in enumerate(units)},
        rates=rates,
        phases=phases,
        starting=starting,
        spare_gates=spares,
        parts=parts,
        alike=_alike(names, events, gates, dependencies, restrictions, owner),
    )


def _is_spare(gate: AnyGate) -> bool:
    return isinstance(gate, DynamicGate) and gate.kind is DynamicKind.SPARE


def _check_gate(gate: AnyGate) -> None:
    if isinstance(gate, Gate) and gate.kind not in _STATIC:
        raise ModelError(
            f"gate '{gate.name}': {gate.kind.value} is not allowed in the group of a dynamic gate; "
            f"allowed: {', '.join(kind.value for kind in _STATIC)}, pand, por, spare"
        )
    if isinstance(gate, DynamicGate) and len(gate.inputs) > LARGEST:
        raise TooLargeError(
            f"gate '{gate.name}': {len(gate.inputs)} inputs of a {gate.kind.value} gate; allowed: "
            f"{LARGEST}"
        )


def _laws(
    events: Sequence[DynamicEvent],
) -> tuple[tuple[float, ...], tuple[int, ...], dict[int, float]]:
    rates, phases, starting = [], [], {}
    for number, event in enumerate(events):
        model = event.model
        rates.append(model.rate if isinstance(model, Exponential | Erlang) else 0.0)
        phases.append(model.phases if isinstance(model, Erlang) else 1)
        if isinstance(model, Constant | PerDemand):
            starting[number] = model.probability(0.0).p
        elif not isinstance(model, Exponential | Erlang):
            if isinstance(model, GLM):
                raise ModelError(
                    f"event '{event.name}': is repaired, which the group of a dynamic gate does "
                    "not allow; leave out its repair, which counts more failures, or the gate"
                )
            raise ModelError(
                f"event '{event.name}': {type(model).__name__} is not allowed in the group of a "
                "dynamic gate, whose events may not depend on the time since the start; "
                "allowed: Constant, Erlang, Exponential, PerDemand"
            )
        if phases[-1] > LARGEST:
            raise TooLargeError(
                f"event '{event.name}': {phases[-1]} phases in the group of a dynamic gate; "
                f"allowed: {LARGEST}"
            )
    return tuple(rates), tuple(phases), starting


def _owners(
    names: Sequence[str],
    inputs: Mapping[int, tuple[int, ...]],
    parents: Sequence[Sequence[int]],
    spares: Sequence[int],
    units: Sequence[int],
) -> tuple[tuple[int | None, ...], dict[int, tuple[int, ...]]]:
    """Return for each element the innermost spare unit that it is or is part of, and their parts.

    A unit that is an input of another gate too, one that is in service from the start, is in
    service with it, and has no owner.
    """
    spare_gates = set(spares)
    first: dict[int, int] = {}
    for gate in spares:
        unit = inputs[gate][0]
        if unit in first:
            raise ModelError(
                f"'{names[unit]}' is in use from the start by two spare gates, "
                f"'{names[first[unit]]}' and '{names[gate]}'; give each its own first input"
            )
        first[unit] = gate
    owner: list[int | None] = [None] * len(names)
    serving = _serving(inputs, parents, spare_gates)
    shared: dict[int, tuple[int, ...]] = {}
    # From above downwards, so that the innermost unit is the last to lay its hand on an element.
    for unit in sorted(units, reverse=True):
        users = [gate for gate in parents[unit] if gate in spare_gates]
        others = [gate for gate in parents[unit] if gate not in spare_gates]
        if others and not serving.issuperset(others):
            other = next(gate for gate in others if gate not in serving)
            raise ModelError(
                f"'{names[unit]}' is a spare of '{names[users[0]]}' and an input of "
                f"'{names[other]}', which may itself be part of a waiting spare; give each its own"
            )
        inside = reached((unit,), lambda element: inputs.get(element, ()))
        for element in sorted(inside - {unit}):
            outside = [gate for gate in parents[element] if gate not in inside]
            if outside and not (others and serving.issuperset(outside)):
                raise ModelError(
                    f"'{names[element]}' is part of the spare '{names[unit]}' and an input of "
                    f"'{names[outside[0]]}' outside it; give each its own"
                )
        for element in inside:
            owner[element] = None if others else unit
        if others:
            shared[unit] = tuple(sorted(inside))
    parts = {
        unit: tuple(element for element, one in enumerate(owner) if one == unit) for unit in units
    }
    return tuple(owner), parts | shared


def _serving(
    inputs: Mapping[int, tuple[int, ...]], parents: Sequence[Sequence[int]], spares: set[int]
) -> set[int]:
    """Return what is in service from the start, not counting the inputs of spare gates."""
    starts = [element for element, above in enumerate(parents) if not above]
    return reached(starts, lambda element: () if element in spares else inputs.get(element, ()))


def _alike(
    names: Sequence[str],
    events: Sequence[DynamicEvent],
    gates: Sequence[AnyGate],
    dependencies: Sequence[Dependency],
    restrictions: Sequence[Restriction],
    owner: Sequence[int | None],
) -> tuple[tuple[int, ...], ...]:
    """Return the sets of events of one law that stand in the same static gates and dependencies."""
    place = {name: number for number, name in enumerate(names)}
    above: list[list[str]] = [[] for _ in events]
    single = {name for tie in restrictions for name in tie.inputs}
    single |= {tie.trigger for tie in dependencies}
    for user in (*gates, *dependencies):
        if isinstance(user, DynamicGate):
            single.update(user.inputs)
        for name in user.inputs:
            if place[name] < len(events):
                above[place[name]].append(user.name)
    classes: dict[object, list[int]] = {}
    for number, event in enumerate(events):
        if event.name not in single:
            key = (event.model, event.dormancy, owner[number], tuple(sorted(above[number])))
            classes.setdefault(key, []).append(number)
    return tuple(tuple(members) for members in classes.values() if len(members) > 1)
