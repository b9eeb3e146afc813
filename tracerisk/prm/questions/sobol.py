"""The share of each input in the spread of a result: first-order Sobol indices from one sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.prm.numbers.arrays import np

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples

_CUTOFF = 1e-10
"""Directions of the regression with less than this share of its greatest are left out."""


def first_order_shares(inputs: Samples, result: Samples) -> Samples:
    """Return the first-order Sobol index of each input: (k,), from (n, k) inputs, (n,) results.

    The index is the variance of E[result | input] over that of the result.
    All conditional means are fitted at once, as a sum of functions of one input each: of its
    value, its square, its rank and the square of that; the regression takes the noise of the
    other inputs out of each, as estimators that look at one input at a time cannot
    (an additive high-dimensional model representation: Li, Rosenthal and Rabitz, J. Phys. Chem.
    A 105 (2001), with a basis of our own; measured in docs/theory.md#uncertainty).
    A share is the covariance of its function with the result over the result's variance, so that
    chance correlations of the sample are dealt out and the shares sum to at most one (Li and
    others, J. Phys. Chem. A 114 (2010)).
    A result or an input that does not vary has shares of zero.
    """
    count, width = inputs.shape
    shares = np.zeros(width)
    # Scaled by the largest, for the square of 1e-200 underflows to zero.
    scale = np.abs(result - result.mean()).max(initial=0.0)
    if scale == 0.0 or count < 2:
        return shares
    centred = (result - result.mean()) / scale
    functions = [_functions(inputs[:, index]) for index in range(width)]
    basis = np.concatenate(functions, axis=1)
    if basis.shape[1] == 0:
        return shares
    values, vectors = np.linalg.eigh(basis.T @ basis)
    kept = values > _CUTOFF * values[-1]
    weights = vectors[:, kept] @ ((vectors[:, kept].T @ (basis.T @ centred)) / values[kept])
    variance = float(centred @ centred)
    start = 0
    for index, columns in enumerate(functions):
        fitted = columns @ weights[start : start + columns.shape[1]]
        start += columns.shape[1]
        shares[index] = max(0.0, float(fitted @ centred) / variance)
    return shares


def _functions(column: Samples) -> Samples:
    """Return orthonormal functions of an input, each with mean zero: (n, up to 4)."""
    spread = column.max() - column.min()
    if spread == 0.0:
        return np.empty((len(column), 0))
    value = (column - column.min()) / spread
    rank = np.empty(len(column))
    rank[np.argsort(column, kind="stable")] = np.linspace(0.0, 1.0, len(column))
    powers = np.column_stack([value, rank, value**2, rank**2])
    left, sizes, _ = np.linalg.svd(powers - powers.mean(axis=0), full_matrices=False)
    kept: Samples = left[:, sizes > 1e-7 * sizes[0]]
    return kept
