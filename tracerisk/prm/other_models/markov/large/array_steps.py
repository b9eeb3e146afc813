"""The distribution of a large chain after a number of steps, without a subtraction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tracerisk.prm.other_models.markov.large.pattern import Array

Entries = tuple[Array, Array, Array]
"""The rows, columns and values of the entries of a sparse matrix."""

_RENORMALISED_EVERY = 64
_DENSE = 2_000


def entries_of(rows: Sequence[Mapping[int, float]]) -> Entries:
    """Return the entries of a matrix given by its rows."""
    return (
        np.repeat(np.arange(len(rows)), [len(row) for row in rows]),
        np.fromiter((j for row in rows for j in row), dtype=np.int64),
        np.fromiter((p for row in rows for p in row.values()), dtype=np.float64),
    )


def power(start: Array, entries: Entries, steps: int, squaring: float) -> Array:
    """Return `start` times the `steps`-th power of a stochastic matrix: (n,).

    `squaring` says how many operations it takes to square the matrix as often as needed; that is
    done where it is faster than to step.
    """
    size = len(start)
    sources, targets, values = entries
    # A product of dense matrices takes far less time for each operation than a sparse one.
    if size <= _DENSE and squaring < 50 * steps * len(values):
        matrix = np.zeros((size, size))
        matrix[sources, targets] = values
        return _power_by_squaring(start, matrix, steps)
    return _power_by_steps(start, entries, steps)


def _power_by_squaring(start: Array, matrix: Array, steps: int) -> Array:
    """Square a dense matrix: (n, n). Each product is divided by its sums."""
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


def _power_by_steps(start: Array, entries: Entries, steps: int) -> Array:
    turned = _turned(entries, len(start))
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
    turned = _turned(entries_of(rows), len(rows))
    now = np.array(start)
    for _ in range(first):
        now = turned @ now
    total = weights[0] * now
    for weight in weights[1:]:
        now = turned @ now
        total = total + weight * now
    return np.asarray(total / total.sum())


def _turned(entries: Entries, size: int) -> Any:
    from scipy.sparse import csr_array

    sources, targets, values = entries
    return csr_array((values, (targets, sources)), shape=(size, size))
