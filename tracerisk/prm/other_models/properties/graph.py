"""What can happen in a chain at all, and what is certain: from its arrows alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tracerisk.common.strong_components import strong_components

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
    following = {
        state: [target for target, weight in row.items() if weight > 0.0]
        for state, row in enumerate(rows)
    }
    found = []
    for component in strong_components(following):
        members = set(component)
        if all(members.issuperset(following[state]) for state in component):
            found.append(sorted(component))
    return sorted(found)
