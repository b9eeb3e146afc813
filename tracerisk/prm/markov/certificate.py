"""Refine a solution, and bound its relative error by what it leaves unexplained.

G is an M-matrix: its inverse has no negative entry. So for x with residual r = b - G x, and any
y with G y >= |r| in every entry, the error of x is at most y, entry by entry (own derivation;
docs/theory.md#large-chains). Neither the solver nor its convergence need be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.prm.markov.residual import left_residual, right_residual

if TYPE_CHECKING:
    from tracerisk.prm.markov.factors import Weights

Array = np.ndarray[Any, Any]
Solver = Callable[[Array], Array]
"""An approximate solution of u G = given or G x = given, of either sign."""

_ROUNDING = 2.0**-53
_WORKING = 2.0**-100
"""Above the relative rounding of one operation in twice the working precision, 2^-104."""
_SMALLEST = 1e-250
"""Values below it are left out of the bound: their products cannot be split without loss."""
_ENOUGH = 1e-17
_TRUSTED = 1e-13


@dataclass(frozen=True, slots=True, eq=False)
class Certified:
    """A solution and the greatest relative error that any of its entries above 1e-250 can have.

    The bound is infinite where none could be had.
    """

    values: Array
    bound: float


def certify(
    weights: Weights, given: Array, solver: Solver, *, left: bool, rounds: int, positive: bool
) -> Certified:
    """Return the solution of u G = given (`left`) or G x = given, refined, with its bound.

    given: (n,), not negative. `positive` says that the solver loses no digits where `given` has
    no negative entry: its own solution is then kept where no refinement can be certified, as in
    chains that end so seldom that twice the working precision does not show it.
    """
    first = np.maximum(solver(given), 0.0)
    if not np.all(np.isfinite(first)):
        return Certified(first, math.inf)
    high, low = first, np.zeros_like(first)
    terms = np.diff(weights.indptr).astype(np.float64) + 4.0
    if left:
        terms = terms + np.bincount(weights.indices, minlength=weights.size)
    scale = _leaving(weights) * first
    # How much a relative residual of one in every entry can come to.
    reach = solver(scale)
    slip, size = _residual(weights, scale, reach, np.zeros_like(reach), left=left)
    with np.errstate(divide="ignore", invalid="ignore"):
        missing = np.nanmax(np.where(scale > 0.0, (slip + _WORKING * terms * size) / scale, 0.0))
    if not missing < 0.5:
        return Certified(first, math.inf)
    best = Certified(first, math.inf)
    for number in range(rounds + 1):
        residual, size = _residual(weights, given, high, low, left=left)
        unknown = np.abs(residual) + _WORKING * terms * size
        bound = _relative_bound(unknown, scale, reach / (1.0 - missing), high)
        if bound < best.bound:
            best = Certified(high.copy(), bound + _ROUNDING)
        if bound < _ENOUGH or number == rounds:
            break
        high, low = _added(high, low, solver(residual))
        if not np.all(np.isfinite(high)):
            break
    if positive and best.bound > _TRUSTED:
        # Twice the working precision is not enough; elimination itself loses no digits.
        return Certified(first, _against(first, best))
    return best


def _relative_bound(unknown: Array, scale: Array, reach: Array, values: Array) -> float:
    """Return the greatest relative error of `values` for what is unknown of their equations."""
    counted = values > _SMALLEST
    if np.any((scale <= 0.0) & (unknown > 0.0)):
        return math.inf
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = float(np.max(np.where(scale > 0.0, unknown / scale, 0.0), initial=0.0))
        return worst * float(np.max(np.where(counted, reach / values, 0.0), initial=0.0))


def _against(first: Array, best: Certified) -> float:
    if not math.isfinite(best.bound):
        return math.inf
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = np.where(best.values > _SMALLEST, np.abs(first / best.values - 1.0), 0.0)
    return float(apart.max(initial=0.0)) + 2.0 * best.bound


def _added(high: Array, low: Array, change: Array) -> tuple[Array, Array]:
    """Return the pair (high, low) with a change added to it, without loss."""
    change = low + change
    total = high + change
    part = total - high
    return total, (high - (total - part)) + (change - part)


def _leaving(weights: Weights) -> Array:
    sums = np.add.reduceat(np.append(weights.data, 0.0), weights.indptr[:-1])
    return np.where(np.diff(weights.indptr) > 0, sums, 0.0) + weights.slack


def _residual(
    weights: Weights, given: Array, high: Array, low: Array, *, left: bool
) -> tuple[Array, Array]:
    kernel: Any = left_residual if left else right_residual
    found: tuple[Array, Array] = kernel(
        weights.indptr, weights.indices, weights.data, weights.slack, given, high, low
    )
    return found
