"""A fault tree's top for many values of the parameters at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tracerisk.errors import ModelError, one_of
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.trees.gates import swept

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from tracerisk.prm.numbers.distributions import Values
    from tracerisk.prm.trees.bdd import SharedTree
    from tracerisk.prm.trees.fault_tree import FaultTree

_CELLS = 4_000_000
"""How many numbers one pass may hold; more samples are taken in passes."""


def top_samples(
    tree: FaultTree, values: Mapping[str, ArrayLike], shared: SharedTree | None
) -> NDArray[np.float64]:
    """Return the top's probability and complement for n samples, (n, 2); see FaultTree."""
    for name in tree.parameters:
        if name not in values:
            raise ModelError(f"parameter '{name}' has no value; {one_of(values, name)}")
    arrays, count = samples_of({name: values[name] for name in tree.parameters})
    step = max(64, _CELLS // (len(tree.events) + len(tree.gates)))
    result = np.empty((count, 2))
    for start in range(0, count, step):
        part: dict[str, Any] = {
            name: np.broadcast_to(array, (count,))[start : start + step]
            for name, array in arrays.items()
        }
        if shared is not None:
            events = {event.name: part[event.parameter] for event in tree.events}
            result[start : start + step] = shared.probabilities(events)
        else:
            top = tree_samples(tree, part)
            result[start : start + step, 0], result[start : start + step, 1] = top
    return result


def samples_of(
    values: Mapping[str, ArrayLike],
) -> tuple[dict[str, NDArray[np.float64]], int]:
    """Return the samples of each parameter as arrays, and how many there are.

    Raises ModelError when one is not a probability or a list of numbers, or has another length.
    """
    arrays: dict[str, NDArray[np.float64]] = {}
    for name, value in values.items():
        arrays[name] = np.asarray(value, dtype=np.float64)
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
        text = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise ModelError(f"arrays of different lengths ({text}); give each the same")
    return arrays, next(iter(counts.values()), 1)


def tree_samples(tree: FaultTree, values: Mapping[str, Values]) -> Probability:
    """Return the top's pair (p, 1-p), each half an array over the draws or a number.

    `values` gives each parameter its probability.
    """
    if tree.shared:
        probabilities = tree.probabilities(values)
        # The pair's type is of numbers; its algebra is that of arrays as well.
        return Probability(probabilities[:, 0], probabilities[:, 1])  # type: ignore[arg-type]
    nodes = {event.name: _pair(values[event.parameter]) for event in tree.events}
    nodes |= {house.name: Probability.of(float(house.state)) for house in tree.houses}
    return swept(tree.upwards, nodes)[tree.top]


def _pair(value: Values) -> Probability:
    # The pair's type is of numbers; its algebra is that of arrays as well.
    return Probability(value, 1.0 - value)  # type: ignore[arg-type]
