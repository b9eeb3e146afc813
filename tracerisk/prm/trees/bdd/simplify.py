"""Simplification of a logic graph before its decision diagram is built.

Every rule keeps the function and lets fewer nodes stand below fewer gates: coalescing of an AND
into the only AND above it, restriction of a literal below its own gate, factoring of common
arguments, and merging of the literals that always stand together.
Rules of this kind: Niemela, "On simplification of large fault trees", Reliability Engineering
and System Safety 44 (1994); Rauzy and Dutuit, "Exact and truncated computations of prime
implicants of coherent and non-coherent fault trees within Aralia", 58 (1997).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain

from tracerisk.prm.trees.bdd.logic import FALSE, TRUE, LogicBuilder, LogicGraph, renamed

MOST_ROUNDS = 12
_MOST_WORK = 3_000_000
"""After this many literals have gone into contexts in one round, contexts are left empty, to bound
the time."""


def simplified(graph: LogicGraph) -> LogicGraph:
    """Return an equal graph that is smaller where the rules find something."""
    rules = (_restricted, _factored, _merged)
    in_vain = 0
    for rule in rules * MOST_ROUNDS:
        before, graph = graph, rule(graph)
        in_vain = in_vain + 1 if graph == before else 0
        if in_vain == len(rules):
            break
    return graph


def _uses(graph: LogicGraph, order: Sequence[int]) -> Counter[int]:
    """Return how many gates each node is an argument of."""
    uses = Counter(map(abs, chain.from_iterable(graph.arguments[node] for node in order)))
    uses[abs(graph.top)] += 1
    return uses


def _contexts(graph: LogicGraph, order: Sequence[int], uses: Counter[int]) -> list[frozenset[int]]:
    """Return for each gate the literals that are true whenever its value matters.

    They are arguments of gates above it, on every way from the top: where one of them is false,
    the gate that it is an argument of is false whatever stands below.
    """
    nothing: frozenset[int] = frozenset()
    contexts: list[frozenset[int] | None] = [None] * len(graph.arguments)
    contexts[abs(graph.top)] = nothing
    work = 0
    for node in reversed(order):
        arguments = graph.arguments[node]
        known = contexts[node] or nothing
        siblings = [a for a in arguments if uses[abs(a)] > 1 and a not in known]
        below = known
        if work > _MOST_WORK:
            below = nothing
        elif siblings:
            below = known.union(siblings)
            work += len(below)
        for argument in arguments:
            child = abs(argument)
            if graph.arguments[child]:
                others = contexts[child]
                if others is None:
                    contexts[child] = below
                elif others is not below:
                    contexts[child] = others & below
                    work += min(len(others), len(below))
    return [context or nothing for context in contexts]


def _restricted(graph: LogicGraph) -> LogicGraph:
    """Set literals to what is known below their gates, and coalesce ANDs into the one above."""
    order = graph.reachable()
    uses = _uses(graph, order)
    contexts = _contexts(graph, order, uses)
    builder = LogicBuilder(graph.events)
    first_gate = graph.first_gate
    absorbed = {
        argument
        for node in order
        for argument in graph.arguments[node]
        if argument >= first_gate and uses[argument] == 1
    }
    made = list(range(len(graph.arguments)))
    for node in order:
        if node < first_gate or node in absorbed:
            continue
        literals: list[int] = []
        stack = [node]
        while stack:
            part = stack.pop()
            known = contexts[part]
            for argument in graph.arguments[part]:
                if argument in known:
                    continue
                if -argument in known:
                    literals.append(FALSE)
                elif argument in absorbed:
                    stack.append(argument)
                else:
                    literals.append(made[argument] if argument > 0 else -made[-argument])
        made[node] = _made(builder, literals, graph.arguments[node])
    return builder.graph(renamed(graph.top, made))


def _made(builder: LogicBuilder, literals: list[int], before: tuple[int, ...]) -> int:
    """Return the AND of literals, by a shortcut if they are the arguments that it had before."""
    now = tuple(literals)
    return builder.ordered(now) if now == before else builder.conjunction(now)


def _factored(graph: LogicGraph) -> LogicGraph:
    """Take a literal that several products of one sum share out of them."""
    order = graph.reachable()
    uses = _uses(graph, order)
    builder = LogicBuilder(graph.events)
    first_gate = graph.first_gate
    made = list(range(len(graph.arguments)))
    for node in order:
        if node < first_gate:
            continue
        literals = []
        own = []
        for argument in graph.arguments[node]:
            child = abs(argument)
            literal = made[child] if argument > 0 else -made[child]
            literals.append(literal)
            if -literal >= first_gate and uses[child] == 1:
                own.append(literal)
        if len(own) > 1:
            products = [set(builder.arguments[-literal]) for literal in own]
            if len(set().union(*products)) < sum(map(len, products)):
                apart = set(own)
                literals = [literal for literal in literals if literal not in apart]
                literals.extend(-product for product in _common_out(builder, products))
        made[node] = _made(builder, literals, graph.arguments[node])
    return builder.graph(renamed(graph.top, made))


def _common_out(builder: LogicBuilder, products: list[set[int]]) -> list[int]:
    """Return literals whose sum is that of the products, common literals taken out.

    Greedy: the literal that most products share goes first, with all that those have in common.
    """
    counts = Counter(literal for product in products for literal in product)
    while counts:
        most = max(counts.values())
        if most < 2:
            break
        literal = min(literal for literal, count in counts.items() if count == most)
        having = [product for product in products if literal in product]
        common = set.intersection(*having)
        rest = [product - common for product in having]
        inner = (
            TRUE
            if not all(rest)
            else builder.disjunction([builder.conjunction(sorted(part)) for part in rest])
        )
        counts.subtract(literal for product in having for literal in product)
        new = common | {inner} if inner != TRUE else common
        products = [product for product in products if literal not in product]
        products.append(new)
        counts.update(new)
    return [builder.conjunction(sorted(product)) for product in products]


def _merged(graph: LogicGraph) -> LogicGraph:
    """Join the literals that stand together in all their gates, with one sign, into one AND."""
    order = graph.reachable()
    places: dict[int, list[int]] = {}
    for node in order:
        for argument in graph.arguments[node]:
            places.setdefault(argument, []).append(node)
    alike: dict[tuple[int, ...], list[int]] = {}
    for literal, above in places.items():
        if -literal not in places and abs(literal) != abs(graph.top):
            alike.setdefault(tuple(above), []).append(literal)
    group_of: dict[int, tuple[int, ...]] = {}
    for gates, together in alike.items():
        whole = any(len(graph.arguments[gate]) == len(together) for gate in gates)
        if len(together) > 1 and len(gates) > 1 and not whole:
            members = tuple(sorted(together, key=abs))
            group_of |= dict.fromkeys(members, members)
    if not group_of:
        return graph
    builder = LogicBuilder(graph.events)
    made = list(range(len(graph.arguments)))
    for node in order:
        if node < graph.first_gate:
            continue
        literals = []
        for argument in graph.arguments[node]:
            group = group_of.get(argument, (argument,))
            if argument == group[0]:
                joined = [made[a] if a > 0 else -made[-a] for a in group]
                literals.append(builder.conjunction(joined) if len(group) > 1 else joined[0])
        made[node] = _made(builder, literals, graph.arguments[node])
    return builder.graph(renamed(graph.top, made))
