"""The latent units of a function's fault tree, and what is left of the tree without them.

A latent unit is a basic event whose failure stays hidden, and the unit failed, until the mission
ends.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

from tracerisk.errors import ModelError
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate
from tracerisk.prm.trees.spares import Spares


class LatentPart(NamedTuple):
    """A group of latent units in a fault tree, which fails the visit by itself."""

    units: tuple[str, ...]
    """Names of the basic events of the units."""
    threshold: int
    """Number of failed units, hidden before or not, that fails the visit."""
    spares: Spares | None = None
    """How the units not required wait; `None` where all units work."""


def latent_parts(
    tree: FaultTree, latent: Collection[str], spares: Mapping[str, Spares] | None = None
) -> tuple[LatentPart, ...]:
    """Return the parts that latent units make of a tree: each fails the top by itself.

    All units whose failure alone fails the top form one part. `spares` are those of the gates.
    Raises ModelError when a unit feeds two gates, stands under one gate with other events, or under
    a gate between its group and the top that is no OR.
    """
    above = {name: gate for gate in tree.gates for name in gate.inputs}
    single: list[str] = []
    groups: dict[str, LatentPart] = {}
    for event in tree.events:
        if event.name not in latent:
            continue
        _check_alone(tree, event.name)
        gate = above.get(event.name)
        if gate is None or _is_or(gate):
            single.append(event.name)
        elif gate.name not in groups:
            others = [name for name in gate.inputs if name not in latent]
            if others or not gate.kind.is_coherent:
                what = (
                    f"it has other inputs, {', '.join(others)}"
                    if others
                    else f"its kind is '{gate.kind.value}'"
                )
                raise ModelError(
                    f"latent unit '{event.name}' is an input of gate '{gate.name}': {what}; "
                    "allowed: a gate 'and', 'or' or 'atleast' with latent units only"
                )
            waiting = (spares or {}).get(gate.name)
            groups[gate.name] = LatentPart(gate.inputs, gate.threshold, waiting)
            _check_alone(tree, gate.name)
            gate = above.get(gate.name)
        while gate is not None:
            _check_alone(tree, gate.name)
            if gate.name not in groups and not _is_or(gate):
                raise ModelError(
                    f"latent unit '{event.name}' is below gate '{gate.name}' "
                    f"({gate.kind.value}); only 'or' gates are allowed between a group and the top"
                )
            gate = above.get(gate.name)
    parts = [LatentPart(tuple(single), 1)] if single else []
    return (*parts, *groups.values())


def without_latent(tree: FaultTree, parts: Iterable[LatentPart]) -> FaultTree:
    """Return the tree with latent units that never fail; the tree itself where there are none."""
    latent = {unit for part in parts for unit in part.units}
    if not latent:
        return tree
    gone = {gate.name for gate in tree.gates if gate.inputs and latent.issuperset(gate.inputs)}
    gone.discard(tree.top)
    below = {name for gate in tree.gates if gate.name in gone for name in gate.inputs}
    sound = [name for name in (*sorted(gone), *sorted(latent)) if name not in below]
    return FaultTree(
        tree.top,
        tuple(gate for gate in tree.gates if gate.name not in gone),
        tuple(event for event in tree.events if event.name not in latent),
        (*tree.houses, *(HouseEvent(name, False) for name in sound)),
    )


def check_latent(
    trees: Mapping[str, FaultTree],
    latent: Iterable[str],
    spares: Mapping[str, Mapping[str, Spares]] | None = None,
) -> None:
    """Raise ModelError, with the state, when `latent` names what no tree of `trees` can carry.

    `spares` gives the gates with spares by state.
    """
    names = list(latent)
    wanted = set(names)
    if len(wanted) < len(names):
        twice = sorted(name for name in wanted if names.count(name) > 1)
        raise ModelError(f"latent: duplicate {', '.join(twice)}; remove one")
    known = {event.name for tree in trees.values() for event in tree.events}
    for name in names:
        if name not in known:
            raise ModelError(f"latent: '{name}' is not a basic event of a fault tree; remove it")
    for state, tree in trees.items():
        try:
            latent_parts(tree, wanted)
        except ModelError as error:
            raise ModelError(f"state '{state}': {error.message}", error.location) from error
        for gate in (spares or {}).get(state, ()):
            _check_spares(state, tree, gate, wanted)


def _check_spares(state: str, tree: FaultTree, name: str, latent: set[str]) -> None:
    where = f"state '{state}': spares of '{name}'"
    gate = next((gate for gate in tree.gates if gate.name == name), None)
    if gate is None or not latent.issuperset(gate.inputs) or _is_or(gate):
        raise ModelError(f"{where}: allowed: a gate 'and' or 'atleast' with latent units only")
    parameters = {event.parameter for event in tree.events if event.name in gate.inputs}
    if len(parameters) > 1:
        raise ModelError(
            f"{where}: its units have the parameters {', '.join(sorted(parameters))}; all units "
            "of a group with spares need the same one"
        )


def _is_or(gate: Gate) -> bool:
    return gate.kind.is_coherent and gate.threshold == 1


def _check_alone(tree: FaultTree, name: str) -> None:
    if name in tree.shared:
        raise ModelError(
            f"'{name}' contains latent units and feeds {' and '.join(tree.shared[name])}; "
            "a latent group must feed one gate only"
        )
