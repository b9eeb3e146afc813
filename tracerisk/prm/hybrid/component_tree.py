"""The part of a function's fault tree that one component makes, by its redundancy."""

from __future__ import annotations

from tracerisk.adder.blocks.block import ComponentEntry
from tracerisk.prm.trees.fault_tree import BasicEvent, Gate, GateKind
from tracerisk.prm.trees.spares import spare_group_failure

# No component can have a name with braces.
_SPARES = "{spares}"


def component_part(entry: ComponentEntry) -> tuple[tuple[Gate, ...], tuple[BasicEvent, ...]]:
    """Return the gates and events of a component; the one called as it is stands for all of it.

    Unit i is the event `<component>[i]`. What hits all units at once is `<component>[all]`, by the
    beta-factor model; a group with spares is one event, `<component>[spares]`, for its units do not
    fail independently: see `spare_group_failure`.
    """
    quantity = entry.quantity.value
    own, common = _parameters_of(entry)
    if quantity == 1:
        return (), (BasicEvent(entry.name, own),)
    redundancy = entry.redundancy.value
    units = tuple(f"{entry.name}[{number}]" for number in range(1, quantity + 1))
    least = quantity - redundancy.required + 1
    if redundancy.has_spares:
        units = (f"{entry.name}[spares]",)
        gate = Gate(entry.name, GateKind.OR, units)
    elif not redundancy or least == 1:
        gate = Gate(entry.name, GateKind.OR, units)
    elif least == quantity:
        gate = Gate(entry.name, GateKind.AND, units)
    else:
        gate = Gate(entry.name, GateKind.ATLEAST, units, least)
    events = tuple(BasicEvent(unit, own) for unit in units)
    if common is None:
        return (gate,), events
    all_units = BasicEvent(f"{entry.name}[all]", common)
    apart = Gate(f"{entry.name} apart", gate.kind, gate.inputs, gate.k)
    whole = Gate(entry.name, GateKind.OR, (apart.name, all_units.name))
    return (whole, apart), (*events, all_units)


def latent_units(entry: ComponentEntry) -> tuple[str, ...]:
    """Return the units of a redundant component whose first failures stay hidden for the mission.

    A group with spares has none: its units are taken as good at each visit.
    """
    quantity, redundancy = entry.quantity.value, entry.redundancy.value
    if quantity == 1 or not redundancy or redundancy.required == quantity or redundancy.has_spares:
        return ()
    if redundancy.detected != "mission_start":
        return ()
    return tuple(f"{entry.name}[{number}]" for number in range(1, quantity + 1))


def component_figures(entry: ComponentEntry) -> tuple[tuple[str, float], ...]:
    """Return the parameters of a component's events, each with its value in one visit."""
    redundancy, value = entry.redundancy.value, entry.probability.value
    own, common = _parameters_of(entry)
    share = redundancy.common_cause if common is not None else 0.0
    single = value if share == 0.0 else (1.0 - share) * value
    if redundancy.has_spares and entry.quantity.value > 1:
        single = spare_group_failure(
            single,
            units=entry.quantity.value,
            required=redundancy.required,
            dormancy=redundancy.dormancy,
            switch=redundancy.switch,
        )
    return ((own, single),) if common is None else ((own, single), (common, share * value))


def is_spare_group(event: BasicEvent) -> bool:
    """Return whether an event stands for a group with spares, see `component_part`."""
    return event.parameter.endswith(f" {_SPARES}")


def _parameters_of(entry: ComponentEntry) -> tuple[str, str | None]:
    """Return the names of a unit's own figure and of the common one; `None` for none.

    No component can have a name with braces.
    """
    redundancy = entry.redundancy.value
    if not redundancy or entry.quantity.value == 1:
        return entry.name, None
    common = f"{entry.name} {{common cause}}" if redundancy.common_cause else None
    if redundancy.has_spares:
        return f"{entry.name} {_SPARES}", common
    return (entry.name if common is None else f"{entry.name} {{own}}"), common
