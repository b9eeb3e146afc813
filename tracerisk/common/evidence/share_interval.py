"""Intervals of a share from counts: how many of so many cells failed."""

from __future__ import annotations

import math
from collections.abc import Sequence

_STEPS = 5000
_TINY = 1e-300


def clopper_pearson(failed: float, tried: float, confidence: float = 0.9) -> tuple[float, float]:
    """Return the two-sided interval of a probability of which `failed` of `tried` are known.

    Clopper and Pearson, Biometrika 26 (1934) 404; the quantiles are those of the beta
    distribution, so that the counts need not be whole.
    """
    if tried <= 0.0:
        return 0.0, 1.0
    tail = (1.0 - confidence) / 2.0
    worked = tried - failed
    low = 0.0 if failed <= 0.0 else beta_quantile(failed, worked + 1.0, tail)
    high = 1.0 if worked <= 0.0 else 1.0 - beta_quantile(worked, failed + 1.0, tail)
    return low, high


def weighted_interval(
    strata: Sequence[tuple[float, int, int]], confidence: float = 0.9
) -> tuple[float, tuple[float, float]]:
    """Return the mean of shares, each with its weight, failed and tried cells, and its interval.

    The interval is that of as many equal cells as have the variance of the weighted mean: the
    effective sample size (Kish, Survey Sampling, 1965).
    """
    total = sum(weight for weight, _, tried in strata if tried)
    if total <= 0.0:
        return 0.0, (0.0, 1.0)
    mean = spread = 0.0
    for weight, failed, tried in strata:
        if tried:
            share = weight / total
            mean += share * failed / tried
            spread += share * share / tried
    cells = 1.0 / spread
    return mean, clopper_pearson(mean * cells, cells, confidence)


def beta_quantile(alpha: float, beta: float, share: float) -> float:
    """Return the value below which `share` of a beta distribution lies, to 1e-12."""
    low, high = 0.0, 1.0
    while high - low > 1e-13 * high:
        middle = (low + high) / 2.0
        if middle in (low, high):
            break
        if beta_below(alpha, beta, middle) < share:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0


def beta_below(alpha: float, beta: float, value: float) -> float:
    """Return the regularized incomplete beta function: the share of a beta below `value`.

    By its continued fraction (NIST Digital Library of Mathematical Functions, 8.17.22),
    evaluated forwards (W. J. Lentz, Applied Optics 15 (1976) 668).
    """
    if value <= 0.0 or value >= 1.0:
        return min(1.0, max(0.0, value))
    if value > (alpha + 1.0) / (alpha + beta + 2.0):
        # There the fraction of the other tail is the one that is soon done.
        return 1.0 - beta_below(beta, alpha, 1.0 - value)
    norm = math.lgamma(alpha + beta) - math.lgamma(alpha) - math.lgamma(beta)
    front = math.exp(norm + alpha * math.log(value) + beta * math.log1p(-value)) / alpha
    numerator, denominator = 1.0, 1.0 / _apart(1.0 - (alpha + beta) * value / (alpha + 1.0))
    fraction = denominator
    for step in range(1, _STEPS):
        for term in _terms(alpha, beta, value, step):
            denominator = 1.0 / _apart(1.0 + term * denominator)
            numerator = _apart(1.0 + term / numerator)
            fraction *= numerator * denominator
        if abs(numerator * denominator - 1.0) < 1e-15:
            break
    return front * fraction


def _terms(alpha: float, beta: float, value: float, step: int) -> tuple[float, float]:
    place = alpha + 2.0 * step
    even = step * (beta - step) * value / ((place - 1.0) * place)
    odd = -(alpha + step) * (alpha + beta + step) * value / (place * (place + 1.0))
    return even, odd


def _apart(value: float) -> float:
    """Return a number that can be divided by."""
    return value if abs(value) > _TINY else _TINY
