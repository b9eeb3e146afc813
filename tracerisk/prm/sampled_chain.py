"""An absorbing chain solved for many draws at once, without a subtraction.

Entries are arrays over the draws, or plain numbers where nothing is sampled.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Samples: TypeAlias = NDArray[np.float64]
    Values: TypeAlias = float | Samples


def absorption_samples(
    rows: Mapping[str, Mapping[str, Values]], entry: str
) -> Mapping[str, Values]:
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
    while len(left) > 1:
        state = min(
            (name for name in left if name != entry),
            key=lambda name: len(left[name]) * len(sources[name]),
        )
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


def _sources(rows: Mapping[str, Mapping[str, Values]]) -> dict[str, dict[str, None]]:
    """Return for each transient state those that lead to it, in order."""
    found: dict[str, dict[str, None]] = {state: {} for state in rows}
    for state, row in rows.items():
        for target in row:
            if target in found:
                found[target][state] = None
    return found


def _total(values: Iterable[Values]) -> Values:
    total: Values = 0.0
    for value in values:
        total = total + value
    return total
