"""The events and gates of a fault tree by number, checked: what every sweep of the tree goes by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.gc_pause import collection_paused
from tracerisk.prm.trees.gates import Gate, check_gate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.prm.trees.fault_tree import FaultTree

_UNSEEN, _OPEN, _DONE = range(3)


@dataclass(frozen=True, slots=True)
class Numbering:
    """The nodes of a tree by number: events, then house events, then gates, each after its inputs.

    The top comes last unless it is an event itself.
    """

    names: tuple[str, ...]
    """Name of each node, (n_nodes,)."""
    gates: tuple[Gate, ...]
    """The gates in the order of their numbers, (n_gates,)."""
    inputs: tuple[tuple[int, ...], ...]
    """Numbers of the inputs of each gate, (n_gates, n_inputs of the gate)."""
    top: int
    """Number of the top event."""

    @property
    def shared(self) -> dict[str, tuple[str, ...]]:
        """The inputs of more than one gate, or of one gate twice, with those gates."""
        counts = bytearray(len(self.names))
        for inputs in self.inputs:
            for number in inputs:
                counts[number] = min(2, counts[number] + 1)
        gates_of: dict[str, list[str]] = {
            self.names[number]: [] for number, count in enumerate(counts) if count > 1
        }
        if gates_of:
            for gate in self.gates:
                for name in gate.inputs:
                    if name in gates_of:
                        gates_of[name].append(gate.name)
        return {name: tuple(gates) for name, gates in gates_of.items()}


def numbered(tree: FaultTree) -> Numbering:
    """Return a tree's numbering.

    Raises ModelError when a name is used twice or has no printable characters, an input is
    unknown, a gate's `k` or inputs do not fit its kind, a gate stands above itself, or a gate or
    event is not below the top.
    """
    with collection_paused(len(tree.events) + len(tree.gates)):
        leaves = [event.name for event in tree.events] + [house.name for house in tree.houses]
        names = leaves + [gate.name for gate in tree.gates]
        numbers = {name: number for number, name in enumerate(names)}
        _check_names(names, numbers)
        if tree.top not in numbers:
            raise ModelError(f"top '{tree.top}' is not a gate or event; {one_of(numbers)}")
        below = [_inputs_of(gate, numbers) for gate in tree.gates]
        order = _upwards(tree, names, below, numbers[tree.top], len(leaves))
        # Gates in the order of the sweep get the numbers from the leaves on.
        renumbered = list(range(len(names)))
        for place, gate in enumerate(order, len(leaves)):
            renumbered[gate] = place
        return Numbering(
            tuple(leaves + [names[gate] for gate in order]),
            tuple(tree.gates[gate - len(leaves)] for gate in order),
            tuple(
                tuple([renumbered[number] for number in below[gate - len(leaves)]])
                for gate in order
            ),
            renumbered[numbers[tree.top]],
        )


def _check_names(names: list[str], numbers: Mapping[str, int]) -> None:
    if len(numbers) < len(names):
        seen: set[str] = set()
        for name in names:
            if name in seen:
                raise ModelError(f"'{name}' names two gates or events; rename one")
            seen.add(name)
    for name in names:
        if not name or not name.isprintable():
            raise ModelError(f"{name!r} names a gate or event; it needs printable characters")


def _inputs_of(gate: Gate, numbers: Mapping[str, int]) -> tuple[int, ...]:
    try:
        inputs = tuple([numbers[name] for name in gate.inputs])
    except KeyError as error:
        name = error.args[0]
        raise ModelError(
            f"gate '{gate.name}': input '{name}' is not a gate or event; {one_of(numbers, name)}"
        ) from None
    check_gate(gate)
    return inputs


def _upwards(
    tree: FaultTree,
    names: list[str],
    below: list[tuple[int, ...]],
    top: int,
    leaves: int,
) -> list[int]:
    """Return the gates, each after those below it; iterative, for trees of any depth."""
    state = bytearray(len(names))
    order: list[int] = []
    stack = [top]
    while stack:
        number = stack.pop()
        if number < 0:
            state[~number] = _DONE
            order.append(~number)
        elif state[number] == _OPEN:
            raise ModelError(f"gate '{names[number]}' depends on itself; break the cycle")
        elif state[number] == _UNSEEN:
            if number < leaves:
                state[number] = _DONE
            else:
                state[number] = _OPEN
                stack.append(~number)
                stack.extend(below[number - leaves][::-1])
    if _UNSEEN in state:
        loose = sorted(name for name, seen in zip(names, state, strict=True) if not seen)
        raise ModelError(
            f"not below the top '{tree.top}': {', '.join(loose)}; connect or remove them"
        )
    return order
