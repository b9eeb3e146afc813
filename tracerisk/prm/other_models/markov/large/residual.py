"""What a solution leaves unexplained, in twice the working precision.

Error-free sums and products of two doubles: T. J. Dekker, "A floating-point technique for
extending the available precision", Numerische Mathematik 18 (1971); D. E. Knuth, "The Art of
Computer Programming", volume 2, 4.2.2.
`tracerisk/prm/compiled/chains.c` does them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracerisk.prm.compiled.library import loop
from tracerisk.prm.other_models.markov.large.pattern import Array

if TYPE_CHECKING:
    from tracerisk.prm.other_models.markov.large.factors import Weights


_right_residual = loop("right_residual", "liddddddddd")
_left_residual = loop("left_residual", "lidddddddd")
_leaving_and_terms = loop("leaving_and_terms", "lididdd")


def right_residual(
    weights: Weights, reward: Array, reward_low: Array, high: Array, low: Array
) -> tuple[Array, Array]:
    """Return reward - G (high + low), and the sum of the sizes of all that it was summed from.

    Ways between states are weighed with the difference of their values, which is exact and
    small where a chain seldom ends. The slack and the reward are pairs of doubles, too.
    """
    residual, size = np.empty(weights.size), np.empty(weights.size)
    chain = (*weights.rows, weights.slack, weights.slack_low)
    _right_residual(*chain, reward, reward_low, high, low, residual, size)
    return residual, size


def left_residual(
    weights: Weights, start: Array, start_low: Array, high: Array, low: Array
) -> tuple[Array, Array]:
    """Return start - (high + low) G, and the sum of the sizes of all that it was summed from."""
    total, error, size = start.copy(), start_low.copy(), np.abs(start)
    chain = (*weights.rows, weights.slack, weights.slack_low)
    _left_residual(*chain, high, low, total, error, size)
    return total + error, size


def leaving_and_terms(weights: Weights) -> tuple[Array, Array, Array]:
    """Return what leaves each state, and how many terms its right and left residuals have."""
    leaving: Array = weights.slack.copy()
    right, left = np.empty(weights.size), np.zeros(weights.size)
    _leaving_and_terms(*weights.rows, weights.ends, leaving, right, left)
    return leaving, right, left


def worst_share(residual: Array, size: Array, terms: Array, scale: Array, unit: float) -> float:
    """Return the greatest of what a residual can be, rounding included, over the scale.

    `unit` bounds the relative rounding of one term. Infinite where something is left of nothing.
    """
    unknown: Array = np.abs(residual) + unit * terms * size
    some = scale > 0.0
    if not np.all(unknown[~some] <= 0.0):
        return np.inf
    return _greatest(unknown[some], scale[some])


def worst_ratio(reach: Array, values: Array, smallest: float) -> float:
    """Return the greatest ratio of the one to the other where the other is above `smallest`."""
    some = values > smallest
    return _greatest(reach[some], values[some])


def _greatest(parts: Array, wholes: Array) -> float:
    """Return the greatest share, or zero; infinite where one is no number at all."""
    with np.errstate(invalid="ignore", over="ignore"):
        greatest = float((parts / wholes).max(initial=0.0))
    return greatest if greatest >= 0.0 else np.inf
