"""Refine a solution, and bound its relative error by what it leaves unexplained.

G is an M-matrix: its inverse has no negative entry. So for x with residual r = b - G x, and any
y with G y >= |r| in every entry, the error of x is at most y, entry by entry (own derivation;
docs/theory.md#large-chains). Neither the solver nor its convergence need be trusted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tracerisk.prm.other_models.markov.large.pattern import Array
from tracerisk.prm.other_models.markov.large.residual import (
    leaving_and_terms,
    left_residual,
    right_residual,
    worst_ratio,
    worst_share,
)

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.factors import Weights

Solver = Callable[[Array], Array]
"""An approximate solution of u G = given or G x = given, of either sign."""

_ROUNDING = 2.0**-53
_WORKING = 2.0**-100
"""Above the relative rounding of one operation in twice the working precision, 2^-104."""
_ROUNDED_UP = 1.0 + 2.0**-20
"""Above what the few roundings of the bound itself can lose of it."""
_SMALLEST = 1e-250
"""Values below it are left out of the bound: their products cannot be split without loss."""
_ENOUGH = 1e-17
_TRUSTED = 1e-13


@dataclass(frozen=True, slots=True, eq=False)
class Certified:
    """A solution with a bound of its error."""

    values: Array
    """Solution by transient state, (n,)."""
    bound: float
    """Greatest relative error of the entries above 1e-250; infinite where none could be proven."""


class Certifier:
    """Refines solutions of one chain, and bounds their errors."""

    def __init__(self, weights: Weights) -> None:
        self._weights = weights
        self._leaving, self._right_terms, self._left_terms = leaving_and_terms(weights)
        self._nothing = np.zeros(weights.size)

    def certify(
        self,
        given: Array,
        solver: Solver,
        *,
        left: bool,
        rounds: int,
        positive: bool,
        given_low: Array | None = None,
    ) -> Certified:
        """Return the solution of u G = given (`left`) or G x = given, refined, with its bound.

        given: (n,), not negative; given_low: what its rounding lost.
        `positive` says that the solver loses no digits where `given` has no negative entry: its
        own solution is then kept where no refinement can be certified, as in chains that end so
        seldom that twice the working precision does not show it.
        """
        first = np.maximum(solver(given), 0.0)
        if not np.all(np.isfinite(first)):
            return Certified(first, math.inf)
        terms = self._left_terms if left else self._right_terms
        residual_of = left_residual if left else right_residual
        high, low = first, self._nothing
        lost = self._nothing if given_low is None else given_low
        scale = self._leaving * first
        # How much a relative residual of one in every entry can come to.
        reach = solver(scale)
        slip, size = residual_of(self._weights, scale, self._nothing, reach, low)
        missing = worst_share(slip, size, terms, scale, _WORKING)
        best = Certified(first, math.inf)
        if not missing < 0.5:
            return best
        for number in range(rounds + 1):
            residual, size = residual_of(self._weights, given, lost, high, low)
            unknown = worst_share(residual, size, terms, scale, _WORKING)
            bound = unknown * worst_ratio(reach, high, _SMALLEST) / (1.0 - missing)
            if bound + _ROUNDING < best.bound:
                best = Certified(high, (bound + _ROUNDING) * _ROUNDED_UP)
            if bound < _ENOUGH or number == rounds:
                break
            high, low = _added(high, low, solver(residual))
            if not np.all(np.isfinite(high)):
                break
        if positive and best.bound > _TRUSTED:
            # Twice the working precision is not enough; elimination itself loses no digits.
            return Certified(first, _against(first, best))
        return best


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
