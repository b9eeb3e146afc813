"""The decision diagram of one module, and what is computed on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from tracerisk.errors import TooLargeError
from tracerisk.prm.compiled.library import no_library
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.trees.bdd.kernel import OUT_OF_NODES
from tracerisk.prm.trees.bdd.logic import LogicGraph
from tracerisk.prm.trees.bdd.modules import Module
from tracerisk.prm.trees.bdd.orders import Order, drawn_orders, walked_orders
from tracerisk.prm.trees.bdd.speed import Loops, fastest_loops

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


@dataclass(frozen=True, slots=True)
class Limits:
    """What the exact solution of a tree that shares events may use."""

    nodes: tuple[int, ...] = (2_000, 8_000, 128_000, 512_000, 2_000_000, 8_000_000, 25_000_000)
    """Budgets of nodes for one module's diagram, tried in turn with several orders of its
    events; about 40 bytes a node."""
    pairs: int = 1 << 24
    """Most pairs of nodes kept for a difference, 16 bytes each."""
    samples_bytes: int = 1 << 26
    """Memory that the sweep of many samples may hold at once [bytes]."""
    bound_nodes: int = 20_000
    """Size of the diagrams that give bounds where no budget suffices [nodes]."""
    swapped: bool = False
    """Whether neighbours in an order swap places, for a second diagram to check the first."""


DEFAULT_LIMITS = Limits()

_MOST_PLAIN = 512_000
"""The largest budget that is tried where the loops are not compiled: some minutes."""
_GO_ON = 2
"""How many walks, and how many orders by FORCE, go on after the second budget; later, one each."""
_NEARLY = 0.95
"""The part of its literals after which an order has come nearly all the way."""


@dataclass(frozen=True, slots=True)
class Diagram:
    """A module's decision diagram: nodes after those below them, edges as `kernel` has them."""

    order: tuple[int, ...]
    """Inputs of the module by level, as node numbers of the logic graph, (n_levels,)."""
    root: int
    """Edge of the function that the diagram represents."""
    level: Any
    """Level of the variable of each node, (n_nodes,) integers."""
    low: Any
    """Edge taken where the variable does not happen, (n_nodes,) integers."""
    high: Any
    """Edge taken where the variable happens, (n_nodes,) integers."""
    loops: Loops
    """Functions that compute on the sequences above, compiled or in Python."""

    @property
    def nodes(self) -> tuple[Any, Any, Any]:
        """The level, low and high edge of each node."""
        return self.level, self.low, self.high

    @property
    def size(self) -> int:
        """The number of nodes, that of the constant included."""
        return len(self.level)

    def happens_at(self, happened: Sequence[bool]) -> bool:
        """Return whether the root happens when just these inputs, by level, have happened."""
        edge = self.root
        while edge >> 1:
            node = edge >> 1
            side = self.high if happened[self.level[node]] else self.low
            edge = int(side[node]) ^ (edge & 1)
        return edge == 0

    def sweep(self, p: Sequence[float], q: Sequence[float]) -> tuple[Any, Any]:
        """Return each node's probability and its complement; `p` and `q` are by level."""
        swept = self.loops.floats(self.size), self.loops.floats(self.size)
        self.loops.sweep(*self.nodes, *self._listed(p, q), *swept)
        return swept

    def gains(
        self,
        p: Sequence[float],
        q: Sequence[float],
        swept: tuple[Any, Any],
        wanted: Sequence[bool],
        limits: Limits,
    ) -> Any:
        """Return for each node of the wanted levels the probability of its high less its low edge.

        Exact to rounding for a coherent tree, unless more than `limits.pairs` pairs are met: the
        differences that then remain are subtracted as they stand.
        """
        loops = self.loops
        size = 1024
        while size < 2 * self.size and size < limits.pairs:
            size *= 2
        levels = len(self.order)
        given = self._listed(p, q)
        chosen = loops.listed([int(want) for want in wanted])
        while True:
            gains = loops.floats(self.size)
            met = loops.edge_gains(
                *self.nodes,
                *given,
                *swept,
                chosen,
                gains,
                loops.integers(size),
                loops.integers(size),
                loops.floats(size),
                loops.integers(5 * (levels + 2)),
                loops.floats(levels + 2),
            )
            if met >= 0 or size >= limits.pairs:
                return gains
            size *= 4

    def derivatives(self, p: Sequence[float], q: Sequence[float], limits: Limits) -> list[float]:
        """Return by level the derivative of the root's probability by the variable's."""
        gains = self.gains(p, q, self.sweep(p, q), [True] * len(p), limits)
        out, reach = self.loops.floats(len(p)), self.loops.floats(self.size)
        self.loops.derivatives(self.root, *self.nodes, *self._listed(p, q), gains, reach, out)
        return [float(value) for value in out]

    def difference(
        self,
        high: tuple[Sequence[float], Sequence[float]],
        low: tuple[Sequence[float], Sequence[float]],
        drops: Sequence[float],
        limits: Limits,
    ) -> float:
        """Return the root's probability at `high` less that at `low`, (p, q) by level each.

        `drops` are the differences of the variables' probabilities.
        """
        gains = self.gains(*low, self.sweep(*low), [drop != 0.0 for drop in drops], limits)
        out = self.loops.floats(self.size)
        self.loops.differences(*self.nodes, *self._listed(*high, drops), gains, out)
        value = float(out[self.root >> 1])
        return -value if self.root & 1 else value

    def sweep_many(self, p: Any, q: Any, limits: Limits) -> tuple[Any, Any]:
        """Return the root's probability and its complement for n assignments.

        p, q: (levels, n) arrays; the results are (n,).
        """
        samples = p.shape[1]
        happens, fails = np.empty(samples), np.empty(samples)
        loops = self.loops
        step = max(1, limits.samples_bytes // (16 * self.size))
        for start in range(0, samples, step):
            part = slice(start, start + step)
            p_part, q_part = np.ascontiguousarray(p[:, part]), np.ascontiguousarray(q[:, part])
            width = p_part.shape[1]
            rows: tuple[Any, Any]
            if loops.sweep_many is None:
                rows = [np.zeros(width)] * self.size, [np.zeros(width)] * self.size
                loops.sweep(*self.nodes, p_part, q_part, *rows)
            else:
                rows = np.empty((self.size, width)), np.empty((self.size, width))
                loops.sweep_many(width, *self.nodes, p_part, q_part, *rows)
            happens[part], fails[part] = (row[self.root >> 1] for row in rows)
        return (fails, happens) if self.root & 1 else (happens, fails)

    def _listed(self, *rows: Sequence[float]) -> list[Any]:
        return [self.loops.listed_floats(list(row)) for row in rows]


def module_pair(
    graph: LogicGraph,
    module: Module,
    diagram: Diagram | None,
    p: Sequence[float],
    q: Sequence[float],
) -> tuple[float, float]:
    """Return the probability of a module's root and of its complement; p and q are by node.

    One without a diagram is a product of independent inputs.
    """
    if diagram is None:
        happens, fails = 1.0, 0.0
        for argument in graph.arguments[module.root]:
            if argument > 0:
                happens, fails = happens * p[argument], fails + happens * q[argument]
            else:
                happens, fails = happens * q[-argument], fails + happens * p[-argument]
        return happens, fails
    order = diagram.order
    nodes = diagram.sweep([p[node] for node in order], [q[node] for node in order])
    happens, fails = (float(side[diagram.root >> 1]) for side in nodes)
    return (fails, happens) if diagram.root & 1 else (happens, fails)


def build_diagram(graph: LogicGraph, module: Module, limits: Limits = DEFAULT_LIMITS) -> Diagram:
    """Return a module's diagram, in the smallest budget and by the first order that fits it.

    Orders by FORCE join those by walks where none of them fits the second budget; after that,
    those that came farthest go on, the farthest first.
    Raises TooLargeError when none fits the last budget, DependencyError when the compiled loops are
    missing and no order fits the budgets tried without them.
    """
    loops = fastest_loops()
    walked: dict[str, Order] = {}
    drawn: dict[str, Order] = {}
    trials: dict[str, _Local] = {}
    reached: dict[str, int] = {}

    def joining(
        named: Iterable[tuple[str, Order]], kind: dict[str, Order]
    ) -> Iterator[tuple[str, _Local]]:
        for name, order in named:
            is_new = order not in walked.values() and order not in drawn.values()
            kind[name] = order
            if is_new:
                yield name, local_of(graph, module, _swapped(order) if limits.swapped else order)

    drawn_from = min(1, len(limits.nodes) - 1)
    given: dict[str, int] = {}  # how many of the budgets each order has been through
    stores: dict[int, tuple[Any, Any, Any]] = {}
    budgets = limits.nodes
    if loops.sweep_many is None:
        budgets = tuple(budget for budget in budgets if budget <= _MOST_PLAIN)
    for number in range(len(budgets)):
        going = [iter(trials.items())]
        if number == 0:
            going.append(joining(walked_orders(graph, module), walked))
        if number == drawn_from:
            going.append(joining(drawn_orders(graph, module, walked, loops), drawn))
        joined = {}
        for name, local in chain(*going):
            joined[name] = local
            # One that has come nearly all the way is given the next budget at once.
            while given.get(name, 0) <= number or (
                given[name] == number + 1 < len(budgets)
                and reached[name] > _NEARLY * len(local.literals)
            ):
                at = max(number, given.get(name, 0))
                given[name] = at + 1
                if at not in stores:
                    stores[at] = store_for(budgets[at], loops)
                diagram, reached[name] = _built(local, stores[at], loops)
                if diagram is not None:
                    return diagram
        stores.pop(number, None)  # no order is given this budget again
        ranked = sorted(joined, key=lambda name: -reached[name])
        if number >= drawn_from:
            kept = _GO_ON if number == drawn_from else 1
            walks = [name for name in ranked if name in walked]
            # FORCE comes far early and can then stand still: no reason to give up a walk.
            ahead = [
                name for name in ranked if name in drawn and reached[name] >= reached[walks[0]]
            ]
            going_on = {*walks[:kept], *ahead[:kept]}
            ranked = [name for name in ranked if name in going_on]
        trials = {name: joined[name] for name in ranked}
    if len(budgets) < len(limits.nodes):
        raise no_library("a tree of this size")
    raise TooLargeError(
        f"a module of {len(module.inputs)} events and {len(module.gates)} gates that share them "
        f"exceeded every budget of its decision diagram: {', '.join(map(str, limits.nodes))} nodes "
        f"with {len(reached)} orders of the events ({'; '.join(reached)}); give larger budgets "
        "(Limits.nodes), or divide the tree"
    )


def _swapped(order: Order) -> Order:
    """Return an order in which each two neighbours have changed places."""
    return tuple(
        order[level ^ 1] if level ^ 1 < len(order) else order[level] for level in range(len(order))
    )


@dataclass(frozen=True, slots=True)
class _Local:
    """A module's gates over its variables by level, as `kernel.build` takes them."""

    order: tuple[int, ...]
    """Inputs of the module by level, as node numbers of the logic graph, (n_levels,)."""
    offsets: list[int]
    """Start of each gate's arguments in `literals`, and the end, (n_gates + 1,)."""
    literals: list[int]
    """Arguments of all gates, deepest first: twice the local number, plus 1 if complemented."""
    last: list[int]
    """Place in `literals` of the last use of each gate, (n_gates,); 0 for the root."""


def local_of(graph: LogicGraph, module: Module, order: tuple[int, ...]) -> _Local:
    """Number a module's inputs by level; each gate's deepest arguments stand first."""
    number = {node: level for level, node in enumerate(order)}
    top = dict(number)
    offsets, literals = [0], []
    for gate in module.gates:
        arguments = sorted(graph.arguments[gate], key=lambda a: (-top[abs(a)], abs(a)))
        top[gate] = top[abs(arguments[-1])]
        number[gate] = len(order) + len(offsets) - 1
        literals += [2 * number[abs(a)] + (a < 0) for a in arguments]
        offsets.append(len(literals))
    last = [0] * len(module.gates)
    for place, literal in enumerate(literals):
        if literal >> 1 >= len(order):
            last[(literal >> 1) - len(order)] = place
    return _Local(order, offsets, literals, last)


def store_for(budget: int, loops: Loops) -> tuple[Any, Any, Any]:
    """Return the nodes, the table and the cache of a store for so many nodes."""
    return (
        loops.integers(4 * budget),
        loops.integers(_power_of_two(budget + budget // 4)),
        loops.integers(3 * _power_of_two(budget)),
    )


def _built(local: _Local, store: tuple[Any, Any, Any], loops: Loops) -> tuple[Diagram | None, int]:
    """Return the diagram, or nothing when it outgrows the store, and how many gates are done."""
    levels = len(local.order)
    used = loops.integers(3)
    root = loops.build(
        levels,
        0,
        loops.listed(local.offsets),
        loops.listed(local.literals),
        loops.listed(local.last),
        loops.listed([-1] * len(local.last)),
        *store,
        loops.integers(6 * (levels + 2)),
        used,
    )
    if root == OUT_OF_NODES:
        return None, int(used[1])
    count = int(used[0])
    kept_nodes = [loops.integers(count) for _ in range(3)]
    kept = loops.extract(root, count, store[0], loops.integers(count), *kept_nodes)
    # The root is the last of those kept: nothing below it stands after it.
    root = 2 * (kept - 1) + (root & 1)
    level, low, high = (sequence[:kept] for sequence in kept_nodes)
    return Diagram(local.order, root, level, low, high, loops), int(used[1])


def _power_of_two(least: int) -> int:
    return 1 << max(4, (least - 1).bit_length())
