"""Orders of a module's variables for its decision diagram, by walks from its root.

A walk meets the gates depth first and takes each input where it first meets it, so that inputs
that stand near each other in the tree stand near each other in the order.
The walks differ in which argument of a gate they take first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from tracerisk.prm.bdd.logic import LogicGraph
from tracerisk.prm.bdd.modules import Module


@dataclass(frozen=True, slots=True)
class _Shape:
    """What the walks go by, for each node of a module."""

    height: dict[int, int]
    uses: dict[int, int]
    weight: dict[int, float]


def orders(graph: LogicGraph, module: Module) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Return the orders to try, best first by experience, each with its name; none twice."""
    shape = _shape(graph, module)
    seen = set()
    for name, key in _KEYS.items():
        order = _walk(graph, module, partial(key, shape))
        if order not in seen:
            seen.add(order)
            yield name, order


def _shape(graph: LogicGraph, module: Module) -> _Shape:
    height = dict.fromkeys(module.inputs, 0)
    uses = dict.fromkeys((*module.inputs, *module.gates), 0)
    weight = dict.fromkeys((*module.inputs, *module.gates), 0.0)
    for gate in module.gates:
        children = [abs(argument) for argument in graph.arguments[gate]]
        height[gate] = 1 + max(height[child] for child in children)
        for child in children:
            uses[child] += 1
    weight[module.root] = 1.0
    for gate in reversed(module.gates):
        children = [abs(argument) for argument in graph.arguments[gate]]
        for child in children:
            weight[child] += weight[gate] / len(children)
    return _Shape(height, uses, weight)


def _as_written(_shape: _Shape, _node: int) -> float:
    return 0.0


_KEYS: dict[str, Callable[[_Shape, int], float]] = {
    "deepest first": lambda shape, node: -shape.height[node],
    "most shared first": lambda shape, node: -shape.uses[node],
    "heaviest first": lambda shape, node: -shape.weight[node],
    "as written": _as_written,
    "shallowest first": lambda shape, node: shape.height[node],
    "least shared first": lambda shape, node: shape.uses[node],
}


def _walk(graph: LogicGraph, module: Module, key: Callable[[int], float]) -> tuple[int, ...]:
    """Return the module's inputs as a depth-first walk meets them, children sorted by `key`."""
    gates = set(module.gates)
    seen = set()
    order = []
    stack = [module.root]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if node in gates:
            children = sorted((abs(a) for a in graph.arguments[node]), key=key)
            stack.extend(reversed(children))
        else:
            order.append(node)
    return tuple(order)
