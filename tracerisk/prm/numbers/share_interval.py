"""Intervals of a share from counts: how many of so many cells failed."""

from __future__ import annotations

from collections.abc import Sequence


def clopper_pearson(failed: float, tried: float, confidence: float = 0.9) -> tuple[float, float]:
    """Return the two-sided interval of a probability of which `failed` of `tried` are known.

    Clopper and Pearson, Biometrika 26 (1934) 404; the quantiles are those of the beta
    distribution, so that the counts need not be whole.
    """
    from scipy.special import betaincinv

    if tried <= 0.0:
        return 0.0, 1.0
    tail = (1.0 - confidence) / 2.0
    worked = tried - failed
    low = 0.0 if failed <= 0.0 else float(betaincinv(failed, worked + 1.0, tail))
    high = 1.0 if worked <= 0.0 else float(betaincinv(failed + 1.0, worked, 1.0 - tail))
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
