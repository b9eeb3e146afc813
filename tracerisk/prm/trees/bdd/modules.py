"""Division of a logic graph into modules: gates whose events stand nowhere else.

A module is solved alone and stands for one event in the module above it.
Linear-time detection: Dutuit and Rauzy, "A linear-time algorithm to find modules of fault trees",
IEEE Transactions on Reliability 45 (1996).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.prm.trees.bdd.logic import LogicBuilder, LogicGraph, renamed

_MOST_MASK_BITS = 2_000_000_000


@dataclass(frozen=True, slots=True)
class Module:
    """A gate over inputs that no gate outside it uses."""

    root: int
    """Node of the gate."""
    inputs: tuple[int, ...]
    """Nodes of the events and of the modules below it, in ascending order."""
    gates: tuple[int, ...]
    """Nodes of the gates from the inputs up to `root`, each after its arguments."""

    @property
    def is_simple(self) -> bool:
        """Whether the module is one AND, each input once."""
        return len(self.gates) == 1


def grouped(graph: LogicGraph) -> LogicGraph:
    """Return an equal graph in which arguments that share events form an AND of their own.

    So each group of arguments that is independent of the others of its gate becomes a module
    whenever it could be one.
    """
    order = graph.reachable()
    uses = [0] * len(graph.arguments)
    for node in order:
        for argument in graph.arguments[node]:
            uses[abs(argument)] += 1
    shared = [n for n in order if n < graph.first_gate and uses[n] > 1]
    if len(shared) * len(order) > _MOST_MASK_BITS:
        return graph
    masks = [0] * len(graph.arguments)
    for bit, node in enumerate(shared):
        masks[node] = 1 << bit
    builder = LogicBuilder(graph.events)
    made = list(range(len(graph.arguments)))
    for node in order:
        if node < graph.first_gate:
            continue
        groups: list[tuple[int, list[int]]] = []
        loose = []
        mask = 0
        for argument in graph.arguments[node]:
            below = masks[abs(argument)]
            literal = made[abs(argument)] if argument > 0 else -made[abs(argument)]
            mask |= below
            if not below:
                loose.append(literal)
                continue
            joined = [literal]
            apart = []
            for other, members in groups:
                if other & below:
                    below |= other
                    joined = members + joined
                else:
                    apart.append((other, members))
            groups = [*apart, (below, joined)]
        masks[node] = mask
        made[node] = builder.conjunction(
            [*loose, *(builder.conjunction(members) for _, members in groups)]
        )
    return builder.graph(renamed(graph.top, made))


def modules(graph: LogicGraph) -> tuple[Module, ...]:
    """Return the modules of a graph, each after those below it; the last is the top's.

    There is none when the top is a constant or an event.
    """
    if not graph.arguments[abs(graph.top)]:
        return ()
    roots = _module_roots(graph)
    table: dict[int, Module] = {}
    for root in roots:
        inputs = set()
        gates = []
        stack = [root]
        seen = {root}
        while stack:
            node = stack.pop()
            gates.append(node)
            for argument in graph.arguments[node]:
                child = abs(argument)
                if child in seen:
                    continue
                seen.add(child)
                if child < graph.first_gate or child in table:
                    inputs.add(child)
                else:
                    stack.append(child)
        table[root] = Module(root, tuple(sorted(inputs)), tuple(sorted(gates)))
    return tuple(table.values())


def _module_roots(graph: LogicGraph) -> list[int]:
    """Return the gates that are modules, each after those below it."""
    size = len(graph.arguments)
    first, second, last = [0] * size, [0] * size, [0] * size
    arguments: Sequence[tuple[int, ...]] = graph.arguments
    date = 0
    after = []
    stack = [abs(graph.top)]
    while stack:
        node = stack.pop()
        date += 1
        if node < 0:
            second[-node] = last[-node] = date
            after.append(-node)
        elif first[node]:
            last[node] = date
        else:
            first[node] = last[node] = date
            if arguments[node]:
                stack.append(-node)
                stack.extend(abs(argument) for argument in reversed(arguments[node]))
            else:
                second[node] = date
    least, most = first[:], last[:]
    roots = []
    for node in after:
        low = min(least[abs(argument)] for argument in arguments[node])
        high = max(most[abs(argument)] for argument in arguments[node])
        if low > first[node] and high < second[node]:
            roots.append(node)
        least[node] = min(low, first[node])
        most[node] = max(high, last[node])
    return roots
