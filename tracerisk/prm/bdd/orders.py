"""Orders of a module's variables for its decision diagram.

A walk meets the gates depth first from the root and takes each input where it first meets it, so
that inputs that stand near each other in the tree stand near each other in the order; the walks
differ in which argument of a gate they take first.
FORCE then draws each input towards the gates that it feeds: Aloul, Markov and Sakallah, "FORCE: a
fast and easy-to-implement variable-ordering heuristic", GLSVLSI 2003.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from tracerisk.prm.bdd.logic import LogicGraph
from tracerisk.prm.bdd.modules import Module
from tracerisk.records import dataclass

_ROUNDS = 30
"""With 30 rounds the diagrams were up to half as large as with 12."""

Order = tuple[int, ...]
"""The inputs of a module, the topmost level first."""


@dataclass(frozen=True, slots=True)
class _Shape:
    """What the walks go by, for each node of a module."""

    height: dict[int, int]
    uses: dict[int, int]
    below: dict[int, int]


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


def drawn_orders(graph: LogicGraph, module: Module) -> Iterator[tuple[str, Order]]:
    """Return the orders by FORCE, each from that of a walk."""
    walked = dict(walked_orders(graph, module))
    children = {gate: [abs(a) for a in graph.arguments[gate]] for gate in module.gates}
    for name in _DRAWN:
        yield f"FORCE from {name}", _drawn(children, walked[name])


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


def _drawn(children: dict[int, list[int]], order: Order) -> Order:
    """Return the order after rounds of FORCE with the least sum of the gates' spans.

    Gates have places as inputs do, and each gate draws itself and its arguments to their mean.
    """
    place: dict[int, float] = {node: float(at) for at, node in enumerate(order)}
    for gate, below in children.items():
        place[gate] = sum(place[child] for child in below) / len(below)
    place = _ranked(place)
    together = [[gate, *below] for gate, below in children.items()]
    counts = dict.fromkeys(place, 0)
    for nodes in together:
        for node in nodes:
            counts[node] += 1
    best, least = order, float("inf")
    for _ in range(_ROUNDS):
        drawn = dict.fromkeys(place, 0.0)
        span = 0.0
        for nodes in together:
            places = [place[node] for node in nodes]
            span += max(places) - min(places)
            mean = sum(places) / len(places)
            for node in nodes:
                drawn[node] += mean
        if span < least:
            least = span
            best = tuple(sorted(order, key=place.__getitem__))
        place = _ranked({node: drawn[node] / counts[node] for node in drawn})
    return best


def _ranked(place: dict[int, float]) -> dict[int, float]:
    """Return the nodes' ranks by place; their spans are comparable from round to round."""
    ranked = sorted(place, key=lambda node: (place[node], node))
    return {node: float(at) for at, node in enumerate(ranked)}
