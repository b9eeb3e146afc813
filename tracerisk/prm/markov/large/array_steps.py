"""The distribution of a large chain after a number of steps, without a subtraction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]

_RENORMALISED_EVERY = 64


def power_by_squaring(start: Array, matrix: Array, steps: int) -> Array:
    """Return `start` times the `steps`-th power of a dense stochastic matrix.

    start: (n,); matrix: (n, n). Each product is divided by its sums.
    """
    now = start
    while steps:
        if steps & 1:
            now = now @ matrix
            now = now / now.sum()
        steps >>= 1
        if steps:
            matrix = matrix @ matrix
            matrix = matrix / matrix.sum(axis=1, keepdims=True)
    return now


def power_by_steps(
    start: Array, sources: Array, targets: Array, values: Array, steps: int
) -> Array:
    """Return `start` after so many steps of a sparse stochastic matrix; start: (n,)."""
    from scipy.sparse import csr_array

    size = len(start)
    turned = csr_array((values, (targets, sources)), shape=(size, size))
    now = start
    for number in range(1, steps + 1):
        now = turned @ now
        if number % _RENORMALISED_EVERY == 0:
            now = now / now.sum()
    return np.asarray(now / now.sum())


def weighted_steps(
    start: Sequence[float],
    rows: Sequence[Mapping[int, float]],
    first: int,
    weights: Sequence[float],
) -> Array:
    """Return the sum of the distributions after `first` steps and on, weighed: (n,)."""
    from scipy.sparse import csr_array

    size = len(rows)
    sources = np.repeat(np.arange(size), [len(row) for row in rows])
    targets = np.fromiter((j for row in rows for j in row), dtype=np.int64)
    values = np.fromiter((p for row in rows for p in row.values()), dtype=np.float64)
    turned = csr_array((values, (targets, sources)), shape=(size, size))
    now = np.array(start)
    for _ in range(first):
        now = turned @ now
    total = weights[0] * now
    for weight in weights[1:]:
        now = turned @ now
        total = total + weight * now
    return np.asarray(total / total.sum())
