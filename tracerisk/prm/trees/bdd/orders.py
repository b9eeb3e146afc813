"""Orders of a module's variables for its decision diagram.

A walk meets the gates depth first from the root and takes each input where it first meets it, so
that inputs that stand near each other in the tree stand near each other in the order; the walks
differ in which argument of a gate they take first.
FORCE then draws each input towards the gates that it feeds: Aloul, Markov and Sakallah, "FORCE: a
fast and easy-to-implement variable-ordering heuristic", GLSVLSI 2003.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import accumulate, chain

from tracerisk.prm.trees.bdd.logic import LogicGraph
from tracerisk.prm.trees.bdd.modules import Module
from tracerisk.prm.trees.bdd.speed import Loops

_ROUNDS = 30
"""With 30 rounds the diagrams were up to half as large as with 12."""

Order = tuple[int, ...]
"""The inputs of a module, the topmost level first."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """What the walks go by, for each node of a module."""

    height: dict[int, int]
    """Longest way down to an input, by node; 0 for an input."""
    uses: dict[int, int]
    """Number of gates in the module that the node feeds, by node."""
    below: dict[int, int]
    """Number of inputs below the node, by node; 1 for an input."""


_WALKS: dict[str, Callable[[_Shape, int], tuple[int, int]]] = {
    "most shared, deepest first": lambda s, node: (-s.uses[node], -s.height[node]),
    "deepest, most shared first": lambda s, node: (-s.height[node], -s.uses[node]),
    "most shared, fewest inputs first": lambda s, node: (-s.uses[node], s.below[node]),
    "shallowest, most shared first": lambda s, node: (s.height[node], -s.uses[node]),
}
_DRAWN = (
    "shallowest, most shared first",
    "deepest, most shared first",
    "most shared, fewest inputs first",
)


def walked_orders(graph: LogicGraph, module: Module) -> Iterator[tuple[str, Order]]:
    """Return the orders by walks, best first by experience, each with its name."""
    shape = _shape(graph, module)
    children = {gate: [abs(a) for a in graph.arguments[gate]] for gate in module.gates}
    for name, key in _WALKS.items():
        ranked = {
            gate: sorted(below, key=lambda node, key=key: key(shape, node))  # type: ignore[misc]
            for gate, below in children.items()
        }
        yield name, _walk(module.root, ranked)


def drawn_orders(
    graph: LogicGraph, module: Module, walked: Mapping[str, Order], loops: Loops
) -> Iterator[tuple[str, Order]]:
    """Return the orders by FORCE, each from one of those by walks."""
    groups = _Groups(graph, module, loops)
    for name in _DRAWN:
        yield f"FORCE from {name}", groups.drawn(walked[name])


def _shape(graph: LogicGraph, module: Module) -> _Shape:
    height = dict.fromkeys(module.inputs, 0)
    below = dict.fromkeys(module.inputs, 1)
    uses = dict.fromkeys((*module.inputs, *module.gates), 0)
    masks = {node: 1 << bit for bit, node in enumerate(module.inputs)}
    for gate in module.gates:
        children = [abs(argument) for argument in graph.arguments[gate]]
        height[gate] = 1 + max(height[child] for child in children)
        mask = 0
        for child in children:
            uses[child] += 1
            mask |= masks[child]
        masks[gate] = mask
        below[gate] = mask.bit_count()
    return _Shape(height, uses, below)


def _walk(root: int, children: dict[int, list[int]]) -> Order:
    """Return the inputs as a depth-first walk meets them; those without children are inputs."""
    seen = set()
    order = []
    stack = [root]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if node in children:
            stack.extend(reversed(children[node]))
        else:
            order.append(node)
    return tuple(order)


class _Groups:
    """A module's gates as groups that draw their members: each gate and its arguments."""

    def __init__(self, graph: LogicGraph, module: Module, loops: Loops) -> None:
        self._loops = loops
        nodes = sorted((*module.inputs, *module.gates))
        self._number = {node: number for number, node in enumerate(nodes)}
        self._below = [
            [self._number[abs(argument)] for argument in graph.arguments[gate]]
            for gate in module.gates
        ]
        self._gates = [self._number[gate] for gate in module.gates]
        sizes = (1 + len(below) for below in self._below)
        self._offsets = loops.listed(list(accumulate(sizes, initial=0)))
        groups = ([gate, *below] for gate, below in zip(self._gates, self._below, strict=True))
        self._members = loops.listed(list(chain.from_iterable(groups)))

    def drawn(self, order: Order) -> Order:
        """Return the order after the rounds, from an order of the inputs on.

        Gates have places as inputs do, at first the mean of those of their arguments.
        """
        place = [0.0] * len(self._number)
        for at, node in enumerate(order):
            place[self._number[node]] = float(at)
        for gate, below in zip(self._gates, self._below, strict=True):
            place[gate] = sum(place[child] for child in below) / len(below)
        best = self._loops.floats(len(place))
        self._loops.draw(
            _ROUNDS,
            self._offsets,
            self._members,
            self._loops.listed_floats(place),
            best,
            self._loops.integers(len(place)),
            self._loops.floats(2 * len(place)),
        )
        return tuple(sorted(order, key=lambda node: best[self._number[node]]))
