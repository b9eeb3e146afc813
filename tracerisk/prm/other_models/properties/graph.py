"""What can happen in a chain at all, and what is certain: from its arrows alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tracerisk.common.strong_components import strong_components

Rows = Sequence[Mapping[int, float]]


def sources_of(rows: Rows) -> list[list[int]]:
    """Return for each state those that lead to it in one move."""
    sources: list[list[int]] = [[] for _ in rows]
    for state, row in enumerate(rows):
        for target, weight in row.items():
            if weight > 0.0 and target != state:
                sources[target].append(state)
    return sources


def reaching(
    sources: Sequence[Sequence[int]], targets: Iterable[int], through: Sequence[bool]
) -> list[bool]:
    """Return which states are targets, or come to one through states of `through` alone."""
    flags = [False] * len(sources)
    waiting = []
    for state in targets:
        flags[state] = True
        waiting.append(state)
    while waiting:
        for state in sources[waiting.pop()]:
            if through[state] and not flags[state]:
                flags[state] = True
                waiting.append(state)
    return flags


def recurrent_classes(rows: Rows) -> list[list[int]]:
    """Return the sets of states that are never left once they are entered."""
    following = {
        state: [target for target, weight in row.items() if weight > 0.0]
        for state, row in enumerate(rows)
    }
    closed = []
    for component in strong_components(following):
        members = set(component)
        if all(members.issuperset(following[state]) for state in component):
            closed.append(sorted(component))
    return sorted(closed)
