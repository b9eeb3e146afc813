"""Directed graphs: what leads where, in which order, and what leads to each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Hashable
    from typing import TypeVar

    N = TypeVar("N", bound=Hashable)
    M = TypeVar("M")


def reached(starts: Iterable[N], onward: Callable[[N], Iterable[N]]) -> set[N]:
    """Return the starts and all nodes that they lead to."""
    ns = set(starts)
    waiting = list(ns)
    while waiting:
        for node in onward(waiting.pop()):
            if node not in ns:
                ns.add(node)
                waiting.append(node)
    return ns


def upwards(
    starts: Iterable[N],
    below: Callable[[N], Iterable[N]],
    cycle: Callable[[list[N]], Exception],
) -> list[N]:
    """Return the starts and all nodes below them, each behind those below itself.

    Starts, and what is below a node, come in their order where they can.
    Raises what `cycle` makes of a path from a start that ends in a node of itself.
    """
    order: dict[N, None] = {}
    opened: dict[N, None] = {}
    for start in starts:
        stack = [(start, False)]
        while stack:
            node, is_ready = stack.pop()
            if is_ready:
                del opened[node]
                order[node] = None
            elif node in opened:
                raise cycle([*opened, node])
            elif node not in order:
                opened[node] = None
                stack.append((node, True))
                stack += [(n, False) for n in reversed([*below(node)])]
    return list(order)


def strong_components(following: Mapping[N, Iterable[N]]) -> list[list[N]]:
    """Return the strongly connected components; each comes after those to which it leads.

    `following` gives every node those to which it leads; starts are tried in its order.
    R. E. Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on Computing 1
    (1972), with a stack of its own in place of recursion.
    """
    index: dict[N, int] = {}
    low: dict[N, int] = {}
    placed: set[N] = set()
    path: list[N] = []
    components = []
    for start in following:
        if start in index:
            continue
        index[start] = low[start] = len(index)
        path.append(start)
        work = [(start, iter(following[start]))]
        while work:
            node, onward = work[-1]
            for n in onward:
                if n not in index:
                    index[n] = low[n] = len(index)
                    path.append(n)
                    work.append((n, iter(following[n])))
                    break
                if n not in placed:
                    low[node] = min(low[node], index[n])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    low[above] = min(low[above], low[node])
                if low[node] == index[node]:
                    first = len(path) - 1
                    while path[first] != node:
                        first -= 1
                    components.append(path[first:])
                    placed.update(path[first:])
                    del path[first:]
    return components


def joined_parts(parts: Iterable[tuple[set[N], list[M]]]) -> list[tuple[set[N], list[M]]]:
    """Join the parts whose sets meet: their sets, and their members, those of earlier ones first.

    A part stands where the last of those that it joins stood.
    """
    pairs: list[tuple[set[N], list[M]]] = []
    for own, members in parts:
        apart = []
        for other, earlier in pairs:
            if other & own:
                own, members = own | other, earlier + members
            else:
                apart.append((other, earlier))
        pairs = [*apart, (own, members)]
    return pairs
