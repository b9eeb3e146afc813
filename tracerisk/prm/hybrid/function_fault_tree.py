"""The fault tree of a function: a top over its components, each by its redundancy."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from tracerisk.adder.blocks.block import ComponentEntry
from tracerisk.prm.hybrid.elements import FunctionState
from tracerisk.prm.hybrid.part_names import (
    all_units_name,
    apart_name,
    parameter_name,
    spare_group_name,
    unit_name,
)
from tracerisk.prm.numbers.probability import Probability, value_of
from tracerisk.prm.trees.events import BasicEvent, Share
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind
from tracerisk.prm.trees.spares import Spares, spare_group_failure


def function_fault_tree(function: str, components: Sequence[ComponentEntry]) -> FaultTree:
    """Return the fault tree of one function: an OR over its components, omitted ones left out.

    In every function a unit of a component is the same event: see `component_part`.
    """
    inputs = []
    gates: list[Gate] = []
    events: list[BasicEvent] = []
    for entry in components:
        if entry.omitted:
            continue
        inputs.append(entry.name)
        own_gates, own_events = component_part(entry)
        gates.extend(own_gates)
        events.extend(own_events)
    # A blank keeps the top's name apart from that of any component.
    top = Gate(f"{function} fails", GateKind.OR, tuple(inputs))
    return FaultTree(top.name, (top, *gates), tuple(events))


def component_part(entry: ComponentEntry) -> tuple[tuple[Gate, ...], tuple[BasicEvent, ...]]:
    """Return a component's gates and events; the one with its own name stands for all of it.

    Unit i is the event `<component>[i]`. What hits all units at once is `<component>[all]`, by the
    beta-factor model.
    """
    quantity = entry.quantity.value
    own = Share.OWN if _has_common_cause(entry) else Share.WHOLE
    if quantity == 1:
        return (), (_event(entry.name, entry, own),)
    redundancy = entry.redundancy.value
    units = tuple(unit_name(entry.name, number) for number in range(1, quantity + 1))
    least = quantity - redundancy.required + 1
    if not redundancy or least == 1:
        gate = Gate(entry.name, GateKind.OR, units)
    elif least == quantity:
        gate = Gate(entry.name, GateKind.AND, units)
    else:
        gate = Gate(entry.name, GateKind.ATLEAST, units, least)
    events = tuple(_event(unit, entry, own) for unit in units)
    if own is Share.WHOLE:
        return (gate,), events
    all_units = _event(all_units_name(entry.name), entry, Share.COMMON_CAUSE)
    apart = Gate(apart_name(entry.name), gate.kind, gate.inputs, gate.k)
    whole = Gate(entry.name, GateKind.OR, (apart.name, all_units.name))
    return (whole, apart), (*events, all_units)


def component_spares(entry: ComponentEntry) -> dict[str, Spares]:
    """Return how the units of a component wait, by its gate; nothing where all of them work."""
    redundancy = entry.redundancy.value
    if not redundancy.has_spares or entry.quantity.value == redundancy.required:
        return {}
    gate = apart_name(entry.name) if redundancy.common_cause else entry.name
    return {gate: Spares(redundancy.dormancy, redundancy.switch)}


def latent_units(entry: ComponentEntry) -> tuple[str, ...]:
    """Return the units of a redundant component whose failures stay hidden for the mission."""
    quantity, redundancy = entry.quantity.value, entry.redundancy.value
    if quantity == 1 or not redundancy or redundancy.required == quantity:
        return ()
    if redundancy.detected != "mission_start":
        return ()
    return tuple(unit_name(entry.name, number) for number in range(1, quantity + 1))


def component_figures(entry: ComponentEntry) -> tuple[tuple[str, float], ...]:
    """Return the parameters of a component's events, each with its value in one visit.

    Of a common cause with the share b the complements are (1-p) + b p and (1-p) + (1-b) p.
    """
    redundancy, value = entry.redundancy.value, entry.probability.value
    if not _has_common_cause(entry):
        return ((entry.name, value),)
    p, q = Probability.of(value)
    share = redundancy.common_cause
    return (
        (
            parameter_name(entry.name, Share.OWN),
            value_of(Probability((1.0 - share) * p, q + share * p)),
        ),
        (
            parameter_name(entry.name, Share.COMMON_CAUSE),
            value_of(Probability(share * p, q + (1.0 - share) * p)),
        ),
    )


def in_one_visit(state: FunctionState, gates: Collection[str] | None = None) -> FunctionState:
    """Return a state with one event for each group with spares, or for those of `gates`.

    The event `<component>[spares]` has the parameter `<component> {spares}`, whose value is the
    probability that a group fails in one visit at whose start all of its units work: they do not
    fail independently, see `spare_group_failure`.
    """
    chosen = [name for name in state.spares if gates is None or name in gates]
    if not chosen:
        return state
    tree, values = state.tree, dict(state.probabilities)
    events = {event.name: event for event in tree.events}
    replaced, added = {}, []
    for gate in tree.gates:
        if gate.name not in chosen:
            continue
        units = gate.inputs
        first = events[units[0]]
        group = BasicEvent(
            spare_group_name(first.component),
            parameter_name(first.component, Share.SPARES),
            component=first.component,
            share=Share.SPARES,
        )
        values[group.parameter] = value_of(
            spare_group_failure(
                values[first.parameter],
                units=len(units),
                required=len(units) - gate.threshold + 1,
                spares=state.spares[gate.name],
            )
        )
        replaced[gate.name] = Gate(gate.name, GateKind.OR, (group.name,))
        added.append(group)
    gone = {unit for gate in tree.gates if gate.name in replaced for unit in gate.inputs}
    tree = FaultTree(
        tree.top,
        tuple(replaced.get(gate.name, gate) for gate in tree.gates),
        (*(event for event in tree.events if event.name not in gone), *added),
        tree.houses,
    )
    return replace(
        state,
        tree=tree,
        probabilities={name: values[name] for name in tree.parameters},
        spares={name: spare for name, spare in state.spares.items() if name not in chosen},
    )


def is_spare_group(event: BasicEvent) -> bool:
    """Return whether an event stands for a group with spares, see `in_one_visit`."""
    return event.share is Share.SPARES


def _has_common_cause(entry: ComponentEntry) -> bool:
    """Return whether a unit's own failures and the common ones are parameters of their own."""
    redundancy = entry.redundancy.value
    return bool(redundancy) and entry.quantity.value > 1 and bool(redundancy.common_cause)


def _event(name: str, entry: ComponentEntry, share: Share) -> BasicEvent:
    parameter = parameter_name(entry.name, share)
    return BasicEvent(name, parameter, component=entry.name, share=share)
