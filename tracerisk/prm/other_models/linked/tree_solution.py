"""Fault trees within a linked model: transfers resolved, solved on pairs, differentiated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from tracerisk.common.strong_components import upwards
from tracerisk.errors import ModelError, TooLargeError, one_of
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions import Expression
from tracerisk.prm.other_models.expressions.rules import along, within
from tracerisk.prm.other_models.linked.elements import LinkedTree
from tracerisk.prm.other_models.linked.links import Link
from tracerisk.prm.trees import bdd
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, gate_shares, slopes, swept

if TYPE_CHECKING:
    from tracerisk.prm.trees.bdd import SharedTree

_LOSES = 1e-2
"""An event whose probability changes by a smaller part is integrated over in a shared tree."""


@dataclass(frozen=True)
class TreeToSolve:
    """A linked tree as one fault tree, made ready for solving."""

    name: str
    """Name of the linked tree."""
    tree: FaultTree
    """The tree with those that it transfers to joined in."""
    inputs: tuple[Expression, ...]
    """Expressions of the events' probabilities, in the order of the events."""

    @cached_property
    def compiled(self) -> SharedTree:
        """The tree made ready for many solutions, for one that shares events or gates."""
        try:
            return bdd.SharedTree(self.tree)
        except TooLargeError as error:
            raise TooLargeError(
                f"fault tree '{self.name}': {error.message}",
                error.location,
                lower=error.lower,
                upper=error.upper,
            ) from error

    def check(self, link: Link) -> None:
        """Accept any link: a tree has one figure."""

    def solve(self, inputs: Sequence[Probability], mission_time_h: float) -> SolvedTree:  # noqa: ARG002
        """Return the tree solved; raise ModelError when an event has no probability."""
        taken = []
        for event, pair in zip(self.tree.events, inputs, strict=True):
            probability = within(pair)
            if probability is None:
                raise ModelError(
                    f"fault tree '{self.name}', event '{event.name}': probability {pair.p!r} is "
                    "outside [0, 1]"
                )
            taken.append(probability)
        return SolvedTree(self, tuple(taken))


def tree_to_solve(tree: LinkedTree, trees: Mapping[str, LinkedTree]) -> TreeToSolve:
    """Return a tree with those that it transfers to joined in.

    Gates of the others are named `tree/gate`.
    Raises ModelError when a transfer leads to no tree, an event has two values, or the tree does
    not hold together.
    """
    gates: list[Gate] = []
    events: dict[str, Expression] = {}
    origin: dict[str, str] = {}
    houses: dict[str, HouseEvent] = {}
    tops: dict[str, str] = {}
    for part in _parts(tree, trees):
        lead = "" if part is tree else f"{part.name}/"
        own = {gate.name: f"{lead}{gate.name}" for gate in part.gates}
        own |= {transfer.name: tops[transfer.tree] for transfer in part.transfers}
        tops[part.name] = own.get(part.top, part.top)
        for event in part.events:
            if events.setdefault(event.name, event.value) != event.value:
                raise ModelError(
                    f"{tree.key}: event '{event.name}' has different values in "
                    f"'{origin[event.name]}' and '{part.name}', which transfers join; "
                    "rename one"
                )
            origin.setdefault(event.name, part.name)
        for house in part.houses:
            if houses.setdefault(house.name, house) != house:
                raise ModelError(
                    f"{tree.key}: house event '{house.name}' has different states in trees that "
                    "transfers join; rename one"
                )
        gates += [
            replace(gate, name=own[gate.name], inputs=tuple(own.get(i, i) for i in gate.inputs))
            for gate in part.gates
        ]
    try:
        joined = FaultTree(
            tops[tree.name],
            tuple(gates),
            tuple(BasicEvent(name) for name in events),
            tuple(houses.values()),
        )
    except ModelError as error:
        raise ModelError(f"{tree.key}: {error.message}") from error
    return TreeToSolve(tree.name, joined, tuple(events.values()))


def _parts(tree: LinkedTree, trees: Mapping[str, LinkedTree]) -> list[LinkedTree]:
    """Return the tree and those that it transfers to, each after those below it."""
    known = {**trees, tree.name: tree}

    def below(name: str) -> list[str]:
        for transfer in reversed(known[name].transfers):
            if transfer.tree not in known:
                raise ModelError(
                    f"{known[name].key}, transfer '{transfer.name}': there is no fault tree "
                    f"'{transfer.tree}'; {one_of(trees, transfer.tree)}"
                )
        return [transfer.tree for transfer in known[name].transfers]

    def cycle(path: list[str]) -> ModelError:
        shown = " -> ".join(f"'{name}'" for name in path)
        return ModelError(f"{tree.key}: transfers form a cycle ({shown}); break the cycle")

    return [known[name] for name in upwards((tree.name,), below, cycle)]


class SolvedTree:
    """A fault tree solved for one set of its events' probabilities, in their order."""

    def __init__(self, made: TreeToSolve, inputs: tuple[Probability, ...]) -> None:
        self._made = made
        self._tree = made.tree
        self._inputs = inputs
        self._nodes: dict[str, Probability] | None = None

    def figure(self, link: Link) -> Probability:  # noqa: ARG002 - a tree has one figure
        """Return the top event's probability."""
        if self._tree.shared:
            return self._made.compiled.probability(self._named(self._inputs))
        return self._swept()[self._tree.top]

    def gradient(self, link: Link) -> Sequence[float]:  # noqa: ARG002
        """Return the derivative of the top event's probability by each event's."""
        return self._slopes(self._inputs)

    def change(self, low: SolvedTree, changes: Sequence[float], link: Link) -> float:  # noqa: ARG002
        """Return the top event's probability less that of `low`."""
        if self._tree.shared:
            return self._change_of_shared(low, changes)
        before, after = self._swept(), low._swept()
        grown = dict.fromkeys((house.name for house in self._tree.houses), 0.0)
        grown |= {
            event.name: value for event, value in zip(self._tree.events, changes, strict=True)
        }
        for gate in self._tree.upwards:
            shares = gate_shares(
                gate,
                [before[name] for name in gate.inputs],
                [after[name] for name in gate.inputs],
            )
            grown[gate.name] = sum(
                share * grown[name] for name, share in zip(gate.inputs, shares, strict=True)
            )
        return grown[self._tree.top]

    def _change_of_shared(self, low: SolvedTree, changes: Sequence[float]) -> float:
        """Take the difference inside the diagram, unless an event's own has lost its digits."""
        lossless = all(
            abs(change) >= _LOSES * max(high.p, below.p)
            for change, high, below in zip(changes, self._inputs, low._inputs, strict=True)
            if change
        )
        if lossless:
            return self._made.compiled.difference(
                self._named(self._inputs), self._named(low._inputs)
            )
        return along(self._slopes, low._inputs, changes)

    def _slopes(self, inputs: Sequence[Probability]) -> Sequence[float]:
        if self._tree.shared:
            sensitivities = self._made.compiled.sensitivities(self._named(inputs))
            return [sensitivities[event.name] for event in self._tree.events]
        nodes = self._swept() if inputs is self._inputs else self._sweep(inputs)
        weights = slopes(self._tree.upwards, self._tree.top, nodes)
        return [weights[event.name] for event in self._tree.events]

    def _swept(self) -> dict[str, Probability]:
        if self._nodes is None:
            self._nodes = self._sweep(self._inputs)
        return self._nodes

    def _sweep(self, inputs: Sequence[Probability]) -> dict[str, Probability]:
        nodes = self._named(inputs)
        for house in self._tree.houses:
            nodes[house.name] = Probability.of(float(house.state))
        return swept(self._tree.upwards, nodes)

    def _named(self, inputs: Sequence[Probability]) -> dict[str, Probability]:
        return {event.name: pair for event, pair in zip(self._tree.events, inputs, strict=True)}
