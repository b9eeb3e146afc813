"""What can happen in a chain at all, and what is certain: from its arrows alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

Rows = Sequence[Mapping[int, float]]


def sources_of(rows: Rows) -> list[list[int]]:
    """Return for each state those that lead to it in one move."""
    found: list[list[int]] = [[] for _ in rows]
    for state, row in enumerate(rows):
        for target, weight in row.items():
            if weight > 0.0 and target != state:
                found[target].append(state)
    return found


def reaching(
    sources: Sequence[Sequence[int]], targets: Iterable[int], through: Sequence[bool]
) -> list[bool]:
    """Return which states are targets, or come to one through states of `through` alone."""
    found = [False] * len(sources)
    waiting = []
    for state in targets:
        found[state] = True
        waiting.append(state)
    while waiting:
        for state in sources[waiting.pop()]:
            if through[state] and not found[state]:
                found[state] = True
                waiting.append(state)
    return found


def recurrent_classes(rows: Rows) -> list[list[int]]:
    """Return the sets of states that are never left once they are entered."""
    component = _components(rows)
    left = {
        component[state]
        for state, row in enumerate(rows)
        for target, weight in row.items()
        if weight > 0.0 and component[target] != component[state]
    }
    found: dict[int, list[int]] = {}
    for state, number in enumerate(component):
        if number not in left:
            found.setdefault(number, []).append(state)
    return list(found.values())


def _components(rows: Rows) -> list[int]:
    """Return for each state a number that those share which lead to each other.

    R. E. Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on Computing 1
    (1972), with a stack of its own in place of recursion.
    """
    order = [0] * len(rows)
    lowest = [0] * len(rows)
    component = [-1] * len(rows)
    path: list[int] = []
    count = 0
    for root in range(len(rows)):
        waiting = [] if order[root] else [(root, iter(rows[root]))]
        while waiting:
            state, onward = waiting[-1]
            if not order[state]:
                count += 1
                order[state] = lowest[state] = count
                path.append(state)
            for target in onward:
                if rows[state][target] <= 0.0:
                    continue
                if not order[target]:
                    waiting.append((target, iter(rows[target])))
                    break
                if component[target] < 0:
                    lowest[state] = min(lowest[state], order[target])
            else:
                waiting.pop()
                if waiting:
                    above = waiting[-1][0]
                    lowest[above] = min(lowest[above], lowest[state])
                if lowest[state] == order[state]:
                    member = -1
                    while member != state:
                        member = path.pop()
                        component[member] = state
    return component
