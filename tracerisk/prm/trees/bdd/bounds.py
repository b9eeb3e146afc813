"""Certified bounds of a module whose diagram outgrows every budget.

Each gate gets two diagrams of bounded size: a function that implies it and one that it implies.
An AND's lower one is the AND of its arguments' lower ones, and so for the upper; a complement
takes the other of the two.
What grows too large is thinned out where that costs least probability, downwards or upwards.
So the probabilities of the top's two functions hold the top's between them, whatever was thinned
out (own derivation; the division of a diagram by worth is after Ravi and Somenzi,
"High-density reachability analysis", ICCAD 1995).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tracerisk.errors import TooLargeError
from tracerisk.prm.trees.bdd.diagram import (
    DEFAULT_LIMITS,
    Limits,
    build_diagram,
    local_of,
    module_pair,
    store_for,
)
from tracerisk.prm.trees.bdd.kernel import OUT_OF_NODES
from tracerisk.prm.trees.bdd.logic import FIRST_EVENT, TRUE, LogicGraph, logic_graph
from tracerisk.prm.trees.bdd.modules import Module, grouped, modules
from tracerisk.prm.trees.bdd.orders import walked_orders
from tracerisk.prm.trees.bdd.simplify import simplified
from tracerisk.prm.trees.bdd.speed import fastest_loops

if TYPE_CHECKING:
    from tracerisk.prm.numbers.probability import Probability
    from tracerisk.prm.trees.fault_tree import FaultTree

LOWER, UPPER = 0, 1
ALWAYS, NEVER = 0, 1
"""The edges of the constants."""

_MOST_CORNERS = 16
_BUDGETS = 4
"""How many of the budgets of nodes are tried before a module's bounds are taken."""


def tree_bounds(
    tree: FaultTree, values: Mapping[str, Probability], limits: Limits = DEFAULT_LIMITS
) -> tuple[float, float]:
    """Return bounds of a tree's probability, certified but for rounding.

    Modules whose diagrams fit the lesser budgets are exact.
    The tree's probability is linear in that of each module, so that its bounds are among those
    with each module at either of its own.
    values: the probability of each event.
    Raises TooLargeError when more than four modules need bounds.
    """
    graph = grouped(simplified(logic_graph(tree)))
    lesser = replace(limits, nodes=limits.nodes[:_BUDGETS])
    size = len(graph.arguments)
    corner = [0.0] * size, [0.0] * size
    corner[0][TRUE] = 1.0
    for node, event in enumerate(graph.events, FIRST_EVENT):
        corner[0][node], corner[1][node] = values[event]
    corners = [corner]
    for module in modules(graph):
        root = module.root
        diagram = None
        try:
            diagram = None if module.is_simple else build_diagram(graph, module, lesser)
        except TooLargeError:
            if len(corners) == _MOST_CORNERS:
                raise
            corners = [
                _at(corner, root, bound)
                for corner in corners
                for bound in module_bounds(graph, module, *corner, limits)
            ]
            continue
        for p, q in corners:
            p[root], q[root] = module_pair(graph, module, diagram, p, q)
    top = graph.top
    result = [(p if top > 0 else q)[abs(top)] for p, q in corners]
    return min(result), max(result)


def _at(
    corner: tuple[list[float], list[float]], node: int, pair: tuple[float, float]
) -> tuple[list[float], list[float]]:
    """Return a corner with one node's probability and complement set."""
    p_nodes, q_nodes = list(corner[0]), list(corner[1])
    p_nodes[node], q_nodes[node] = pair
    return p_nodes, q_nodes


def module_bounds(
    graph: LogicGraph, module: Module, p: Sequence[float], q: Sequence[float], limits: Limits
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return bounds of the probability of a module's root, its inputs' being exact.

    Each with its complement, which is not lost where the probability is near one.
    p, q: by node of the graph.
    """
    order = next(order for _, order in walked_orders(graph, module))
    return _Thinning(graph, module, order, p, q, limits).bounds()


class _Thinning:
    """A store of nodes, and the edges of each gate's lower and upper function in it."""

    def __init__(
        self,
        graph: LogicGraph,
        module: Module,
        order: tuple[int, ...],
        p: Sequence[float],
        q: Sequence[float],
        limits: Limits,
    ) -> None:
        self._loops = fastest_loops()
        self._local = local_of(graph, module, order)
        self._levels = len(order)
        self._most = limits.bound_nodes
        store = 64 * limits.bound_nodes
        integers, floats = self._loops.integers, self._loops.floats
        self._p = self._loops.listed_floats([p[node] for node in order])
        self._q = self._loops.listed_floats([q[node] for node in order])
        self._gates = len(self._local.offsets) - 1
        # Two edges for each gate, and one for what is being joined.
        self._edges = self._loops.listed([-1] * (2 * self._gates + 1))
        self._store = store_for(store, self._loops)
        self._frames = integers(6 * (self._levels + 2))
        # All of the store is in use from the first: what is thinned out needs room at once.
        self._used = self._loops.listed([0, 0, store])
        self._most_used = store // 2
        self._scratch: tuple[Any, ...] = (
            floats(store),
            floats(store),
            floats(2 * store),
            integers(2 * store),
        )

    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the bounds of the last gate, each with its complement."""
        last_use = self._last_uses()
        for gate in range(self._gates):
            for side in (LOWER, UPPER):
                self._edges[2 * gate + side] = self._joined(gate, side)
            for other, last in last_use.get(gate, ()):
                if last == gate:
                    self._edges[2 * other] = self._edges[2 * other + 1] = -1
        lower, upper = self._edges[-3], self._edges[-2]
        return self._probability(int(lower)), self._probability(int(upper))

    def _last_uses(self) -> dict[int, list[tuple[int, int]]]:
        """Return by gate the gates that it is the last to use."""
        last: dict[int, int] = {}
        for gate in range(self._gates):
            for literal in self._literals(gate):
                if literal >> 1 >= self._levels:
                    last[(literal >> 1) - self._levels] = gate
        last_uses: dict[int, list[tuple[int, int]]] = {}
        for other, gate in last.items():
            last_uses.setdefault(gate, []).append((other, gate))
        return last_uses

    def _literals(self, gate: int) -> list[int]:
        offsets = self._local.offsets
        return self._local.literals[offsets[gate] : offsets[gate + 1]]

    def _joined(self, gate: int, side: int) -> int:
        """Return the edge of a gate's lower or upper function, thinned out where need be."""
        self._edges[-1] = ALWAYS
        for literal in self._literals(gate):
            self._conjoin(self._of_side(literal, side), side)
        return int(self._edges[-1])

    def _of_side(self, literal: int, side: int) -> int:
        """Return the literal of the side's function of an argument."""
        item, sign = literal >> 1, literal & 1
        if item < self._levels:
            return literal
        return 2 * (self._levels + 2 * (item - self._levels) + (side ^ sign)) + sign

    def _conjoin(self, literal: int, side: int) -> None:
        """Join a function into the last edge."""
        last = 2 * self._gates
        made = self._loops.build(
            self._levels,
            last,
            self._loops.listed([0, 2]),
            self._loops.listed([2 * (self._levels + last), literal]),
            self._loops.listed([]),
            self._edges,
            *self._store,
            self._frames,
            self._used,
        )
        if made != OUT_OF_NODES:
            self._thin(side)
        # Too large for the store: the lower function becomes `never`; the upper one leaves this
        # argument out.
        elif side == LOWER:
            self._edges[-1] = NEVER

    def _thin(self, side: int) -> None:
        # Thinning adds new nodes to the old ones: free room for them first.
        if self._used[0] > self._most_used:
            self._tidy()
        edge = int(self._edges[-1])
        happens, fails, reach, under = self._scratch
        number = self._loops.thinned(
            edge ^ side,
            self._most,
            *self._store[:2],
            self._p,
            self._q,
            happens,
            fails,
            reach,
            under,
            self._used,
        )
        if number == OUT_OF_NODES:
            self._tidy()
            number = NEVER
        self._edges[-1] = number ^ side

    def _tidy(self) -> None:
        """Give up the nodes that no edge needs."""
        self._loops.collect(self._edges, *self._store, self._used)

    def _probability(self, edge: int) -> tuple[float, float]:
        count = int(self._used[0])
        number = self._loops.integers(count)
        level, low, high = (self._loops.integers(count) for _ in range(3))
        kept = self._loops.extract(edge, count, self._store[0], number, level, low, high)
        happens, fails = self._loops.floats(kept), self._loops.floats(kept)
        self._loops.sweep(level[:kept], low[:kept], high[:kept], self._p, self._q, happens, fails)
        pair = float(happens[kept - 1]), float(fails[kept - 1])
        return pair[::-1] if edge & 1 else pair
