"""What a solution leaves unexplained, in twice the working precision.

Error-free sums and products of two doubles: T. J. Dekker, "A floating-point technique for
extending the available precision", Numerische Mathematik 18 (1971); D. E. Knuth, "The Art of
Computer Programming", volume 2, 4.2.2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba

Array = np.ndarray[Any, Any]

_SPLITTER = 134217729.0  # 2^27 + 1


@compiled_by_numba
def exact_sum(a: float, b: float) -> tuple[float, float]:
    """Return the rounded sum of two doubles, and what rounding lost."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@compiled_by_numba
def _product(a: float, b: float) -> tuple[float, float]:
    product = a * b
    scaled = _SPLITTER * a
    a_high = scaled - (scaled - a)
    a_low = a - a_high
    scaled = _SPLITTER * b
    b_high = scaled - (scaled - b)
    b_low = b - b_high
    lost = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, lost


@compiled_by_numba
def right_residual(
    indptr: Array,
    indices: Array,
    data: Array,
    slack: Array,
    slack_low: Array,
    reward: Array,
    reward_low: Array,
    high: Array,
    low: Array,
) -> tuple[Array, Array]:
    """Return reward - G (high + low), and the sum of the sizes of all that it was summed from.

    Ways between states are weighed with the difference of their values, which is exact and
    small where a chain seldom ends. The slack and the reward are pairs of doubles, too.
    """
    n = len(slack)
    residual = np.empty(n, np.float64)
    size = np.empty(n, np.float64)
    for i in range(n):
        value = high[i]
        rest = low[i]
        product, lost = _product(slack[i], value)
        total, error = exact_sum(reward[i], -product)
        error += reward_low[i] - (lost + slack[i] * rest + slack_low[i] * value)
        magnitude = abs(reward[i]) + product
        for t in range(indptr[i], indptr[i + 1]):
            j = indices[t]
            difference, left = exact_sum(high[j], -value)
            left += low[j] - rest
            product, lost = _product(data[t], difference)
            total, carried = exact_sum(total, product)
            error += carried + (lost + data[t] * left)
            magnitude += abs(product) + data[t] * (abs(low[j]) + abs(rest))
        residual[i] = total + error
        size[i] = magnitude
    return residual, size


@compiled_by_numba
def left_residual(
    indptr: Array,
    indices: Array,
    data: Array,
    slack: Array,
    slack_low: Array,
    start: Array,
    start_low: Array,
    high: Array,
    low: Array,
) -> tuple[Array, Array]:
    """Return start - (high + low) G, and the sum of the sizes of all that it was summed from."""
    n = len(slack)
    total = start.copy()
    error = start_low.copy()
    magnitude = np.abs(start)
    for i in range(n):
        value = high[i]
        rest = low[i]
        leaving = slack[i]
        lost_leaving = slack_low[i]
        for t in range(indptr[i], indptr[i + 1]):
            j = indices[t]
            leaving, carried = exact_sum(leaving, data[t])
            lost_leaving += carried
            product, lost = _product(value, data[t])
            total[j], carried = exact_sum(total[j], product)
            error[j] += carried + (lost + rest * data[t])
            magnitude[j] += abs(product)
        product, lost = _product(value, leaving)
        total[i], carried = exact_sum(total[i], -product)
        error[i] += carried - (lost + value * lost_leaving + rest * leaving)
        magnitude[i] += abs(product)
    return total + error, magnitude


@compiled_by_numba
def leaving_and_terms(
    indptr: Array, indices: Array, data: Array, slack: Array, ends: Array
) -> tuple[Array, Array, Array]:
    """Return what leaves each state, and how many terms its right and left residuals have.

    `ends` counts the ways that the slack of each state sums.
    """
    n = len(slack)
    leaving = slack.copy()
    right = np.empty(n, np.float64)
    left = np.zeros(n, np.float64)
    for i in range(n):
        total = leaving[i]
        for t in range(indptr[i], indptr[i + 1]):
            total += data[t]
            left[indices[t]] += 1.0
        leaving[i] = total
        right[i] = indptr[i + 1] - indptr[i] + ends[i] + 4.0
        left[i] += right[i]
    return leaving, right, left


@compiled_by_numba
def worst_share(residual: Array, size: Array, terms: Array, scale: Array, unit: float) -> float:
    """Return the greatest of what a residual can be, rounding included, over the scale.

    `unit` bounds the relative rounding of one term. Infinite where something is left of nothing.
    """
    worst = 0.0
    for i in range(len(residual)):
        unknown = abs(residual[i]) + unit * terms[i] * size[i]
        if scale[i] > 0.0:
            share = unknown / scale[i]
            if share > worst:
                worst = share
            elif not share <= worst:
                # No number at all.
                return np.inf
        elif not unknown <= 0.0:
            return np.inf
    return worst


@compiled_by_numba
def worst_ratio(reach: Array, values: Array, smallest: float) -> float:
    """Return the greatest ratio of the one to the other where the other is above `smallest`."""
    worst = 0.0
    for i in range(len(reach)):
        if values[i] > smallest:
            ratio = reach[i] / values[i]
            if ratio > worst:
                worst = ratio
            elif not ratio <= worst:
                return np.inf
    return worst
