"""Failure figures after what was observed in the field (Bayes).

Rates take a gamma prior, probabilities per demand a beta prior; the posterior adds failures and
exposure to it (C. L. Atwood et al., "Handbook of Parameter Estimation for Probabilistic Risk
Assessment", NUREG/CR-6823, 2003, 6.2.2 and 6.3.2). The prior has the mean and the variance of the
lognormal that value and error factor give; without an error factor it is Jeffreys' (6.2.2.5.2,
6.3.2.3.2), and the value itself counts for nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from tracerisk.common.dependencies import require_large

NORMAL_95 = 1.6448536269514722
"""The 95 % quantile of the standard normal distribution."""


@dataclass(frozen=True, slots=True)
class Posterior:
    """A figure after the field."""

    mean: float
    """The mean of the distribution, in the unit of the figure."""
    error_factor: float
    """The 95th percentile over the median."""
    alpha: float
    """The first parameter of the gamma or beta distribution: failures, with those of the prior."""
    beta: float
    """The second: the exposure of a gamma in units of the basis; successes of a beta."""


def gamma_posterior(
    value: float,
    error_factor: float | None,
    failures: int,
    exposure: float,
    *,
    value_is: Literal["median", "mean"] = "median",
) -> Posterior:
    """Return a rate after `failures` in an exposure, in the unit of time that the rate is per.

    Raises ValueError for an exposure or failures below zero, and for no failures in no exposure
    without a prior.
    """
    _check(failures, exposure)
    alpha, beta = 0.5, 0.0
    if error_factor is not None:
        mean, relative = _moments(value, error_factor, value_is)
        alpha = 1.0 / relative
        beta = alpha / mean
    alpha, beta = alpha + failures, beta + exposure
    if beta <= 0.0:
        raise ValueError("without exposure and without an error factor nothing is known")
    require_large("scipy")
    from scipy.special import gammaincinv

    high, middle = (float(gammaincinv(alpha, share)) for share in (0.95, 0.5))
    return Posterior(alpha / beta, high / middle, alpha, beta)


def beta_posterior(
    value: float,
    error_factor: float | None,
    failures: int,
    demands: float,
    *,
    value_is: Literal["median", "mean"] = "median",
) -> Posterior:
    """Return a probability per demand after `failures` in so many demands.

    Raises ValueError as `gamma_posterior`, and for more failures than demands.
    """
    _check(failures, demands)
    if failures > demands:
        raise ValueError(f"{failures} failures in {demands:g} demands; there are too few demands")
    alpha, beta = 0.5, 0.5
    if error_factor is not None:
        mean, relative = _moments(value, error_factor, value_is)
        size = (1.0 - mean) / (mean * relative) - 1.0
        if size <= 0.0:
            raise ValueError(
                f"no probability has the mean {mean:.4g} and an error factor of {error_factor:g}"
            )
        alpha, beta = mean * size, (1.0 - mean) * size
    alpha, beta = alpha + failures, beta + (demands - failures)
    require_large("scipy")
    from scipy.special import betaincinv

    high, middle = (float(betaincinv(alpha, beta, share)) for share in (0.95, 0.5))
    return Posterior(alpha / (alpha + beta), high / middle, alpha, beta)


def _moments(value: float, error_factor: float, value_is: str) -> tuple[float, float]:
    """Return the mean of a lognormal, and its variance over the square of that."""
    if not value > 0.0 or not error_factor > 1.0:
        raise ValueError("a prior needs a value above 0 and an error factor above 1")
    variance = (math.log(error_factor) / NORMAL_95) ** 2
    mean = value if value_is == "mean" else value * math.exp(variance / 2.0)
    return mean, math.expm1(variance)


def _check(failures: int, exposure: float) -> None:
    if failures < 0 or not 0.0 <= exposure < math.inf:
        raise ValueError(f"{failures} failures in {exposure:g}: give numbers of 0 or more")
