"""The parts of a directed graph whose members all lead to each other."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

N = TypeVar("N", bound=Hashable)


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
    found = []
    for start in following:
        if start in index:
            continue
        index[start] = low[start] = len(index)
        path.append(start)
        work = [(start, iter(following[start]))]
        while work:
            node, onward = work[-1]
            for each in onward:
                if each not in index:
                    index[each] = low[each] = len(index)
                    path.append(each)
                    work.append((each, iter(following[each])))
                    break
                if each not in placed:
                    low[node] = min(low[node], index[each])
            else:
                work.pop()
                if work:
                    above = work[-1][0]
                    low[above] = min(low[above], low[node])
                if low[node] == index[node]:
                    first = len(path) - 1
                    while path[first] != node:
                        first -= 1
                    found.append(path[first:])
                    placed.update(path[first:])
                    del path[first:]
    return found
