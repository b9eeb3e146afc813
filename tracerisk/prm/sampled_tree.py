"""A fault tree's top for many values of its parameters at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.sampled_mission import tree_samples

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from tracerisk.prm.bdd import SharedTree
    from tracerisk.prm.fault_tree import FaultTree

_CELLS = 4_000_000
"""How many numbers one pass may hold; more samples are taken in passes."""


def top_samples(
    tree: FaultTree, values: Mapping[str, ArrayLike], shared: SharedTree | None
) -> NDArray[np.float64]:
    """Return the top's probability and complement for n samples, (n, 2); see FaultTree."""
    arrays: dict[str, NDArray[np.float64]] = {}
    for name in tree.parameters:
        if name not in values:
            raise ModelError(f"parameter '{name}' has no value; {one_of(values, name)}")
        arrays[name] = np.asarray(values[name], dtype=np.float64)
        if arrays[name].ndim > 1:
            raise ModelError(
                f"parameter '{name}': an array of shape {arrays[name].shape}; give one number, "
                "or one for each sample"
            )
        if not np.all((arrays[name] >= 0.0) & (arrays[name] <= 1.0)):
            raise ModelError(
                f"parameter '{name}': a probability is outside [0, 1]; give numbers within"
            )
    counts = {name: array.size for name, array in arrays.items() if array.ndim}
    if len(set(counts.values())) > 1:
        told = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise ModelError(f"arrays of different lengths ({told}); give each the same")
    count = next(iter(counts.values()), 1)
    step = max(64, _CELLS // (len(tree.events) + len(tree.gates)))
    found = np.empty((count, 2))
    for start in range(0, count, step):
        part: dict[str, Any] = {
            name: np.broadcast_to(array, (count,))[start : start + step]
            for name, array in arrays.items()
        }
        if shared is not None:
            events = {event.name: part[event.parameter] for event in tree.events}
            found[start : start + step] = shared.probabilities(events)
        else:
            top = tree_samples(tree, part)
            found[start : start + step, 0], found[start : start + step, 1] = top
    return found
