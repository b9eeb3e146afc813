"""The failure probabilities of a component's instances in one function, as the lock keeps them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

InstanceValues = Mapping[str, Mapping[str, float]]
"""By component and element the failure probability of one unit in one visit of a function."""

ALIKE = 0.01
"""The relative difference up to which instances count as equal: that of noise."""


def are_alike(probabilities: Iterable[float]) -> bool:
    """Return whether units fail alike, within noise."""
    values = list(probabilities)
    return not values or max(values) <= (1.0 + ALIKE) * min(values)


def kept_values(summary: Mapping[str, Any], function: str) -> dict[str, dict[str, float]]:
    """Return the instances' values that the lock's summary of a trace holds of a function.

    `function` is its name in the model. What has another form than the tool gives it, as a lock
    edited by hand may have, is left out.
    """
    table: Any = summary
    for key in ("functions", function, "instances"):
        table = table.get(key) if isinstance(table, dict) else None
    if not isinstance(table, dict):
        return {}
    return {
        component: {name: p for name, p in values.items() if isinstance(p, (int, float))}
        for component, values in table.items()
        if isinstance(values, dict)
    }
