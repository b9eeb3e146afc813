"""An absorbing chain solved for many draws at once, without a subtraction.

Entries are arrays over the draws, or plain numbers where nothing is sampled.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Values


def absorption(
    rows: Mapping[Hashable, Mapping[Hashable, Values]], entry: Hashable
) -> Mapping[Hashable, Values]:
    """Return for each absorbing state the probability of ending there from `entry`: (n,).

    `rows` gives each transient state its ways out, of which at least one is not zero; what is no
    row is absorbing.
    Ways back to oneself do not matter to where the chain ends; see `MarkovChain.solve`.
    """
    left = {
        state: {target: p for target, p in row.items() if target != state}
        for state, row in rows.items()
    }
    sources = _sources(left)
    rank = {state: number for number, state in enumerate(left)}
    names = list(left)

    def fill_in(state: Hashable) -> int:
        return len(left[state]) * len(sources[state])

    # Least fill-in first; an entry of the heap that has grown since goes back with what it is now.
    waiting = [(fill_in(state), rank[state]) for state in left if state != entry]
    heapify(waiting)
    while waiting:
        weight, number = heappop(waiting)
        state = names[number]
        if fill_in(state) > weight:
            heappush(waiting, (fill_in(state), number))
            continue
        row = left.pop(state)
        leaving = _total(row.values())
        outgoing = {target: p / leaving for target, p in row.items()}
        for target in outgoing:
            if target in sources:
                sources[target].pop(state, None)
        for source in sources.pop(state):
            there = left[source]
            p = there.pop(state)
            for target, share in outgoing.items():
                if target != source:
                    way = p * share
                    there[target] = there[target] + way if target in there else way
                    if target in sources:
                        sources[target][source] = None
    row = left[entry]
    leaving = _total(row.values())
    return {target: p / leaving for target, p in row.items()}


def _sources(
    rows: Mapping[Hashable, Mapping[Hashable, Values]],
) -> dict[Hashable, dict[Hashable, None]]:
    """Return for each transient state those that lead to it, in order."""
    sources: dict[Hashable, dict[Hashable, None]] = {state: {} for state in rows}
    for state, row in rows.items():
        for target in row:
            if target in sources:
                sources[target][state] = None
    return sources


def _total(values: Iterable[Values]) -> Values:
    total: Values = 0.0
    for value in values:
        total = total + value
    return total
