"""A fault tree that shares events or gates, made ready to be solved for many values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.probability import Probability

if TYPE_CHECKING:
    from tracerisk.prm.fault_tree import FaultTree

EventValues = Mapping[str, Probability]
"""The probability of each basic event, by its name."""


class SharedTree:
    """A compiled fault tree."""

    def __init__(self, tree: FaultTree) -> None:
        for name, gates in tree.shared.items():
            raise ModelError(
                f"'{name}' is shared: it is an input {len(gates)} times, of "
                f"{', '.join(sorted(set(gates)))}; only trees in which every event and gate is "
                "an input once can be solved: give each its own event, or restructure the tree"
            )

    def probability(self, values: EventValues) -> Probability:
        """Return the top event's probability."""
        raise NotImplementedError

    def sensitivities(self, values: EventValues) -> dict[str, float]:
        """Return for each basic event the derivative of the top's probability by its own."""
        raise NotImplementedError

    def difference(self, high: EventValues, low: EventValues) -> float:
        """Return the top's probability with `high` less that with `low`, without cancellation."""
        raise NotImplementedError


def compiled(tree: FaultTree) -> SharedTree:
    """Return the tree made ready for solving."""
    return SharedTree(tree)
