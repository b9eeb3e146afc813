"""How far a parameter may be off: distributions by their quantiles, over arrays.

numpy and scipy are imported when something is sampled, not before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, runtime_checkable

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.special import special

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Samples = NDArray[np.float64]
    Values = float | Samples

NORMAL_95 = 1.6448536269514722
"""The 95 % quantile of the standard normal distribution."""


@runtime_checkable
class Distribution(Protocol):
    """A distribution of a parameter, which may be stated relative to its point value."""

    def quantiles(self, shares: Samples, value: float) -> Samples:
        """Return the quantiles at `shares`, each within (0, 1); `value` is the point value."""
        ...

    def mean(self, value: float) -> float:
        """Return the mean of the distribution of a parameter with the point value `value`."""
        ...


@dataclass(frozen=True, slots=True)
class Lognormal:
    """Lognormal about the point value, which is its median or its mean.

    Source of the error factor: "PRA Procedures Guide", NUREG/CR-2300 (1983), 5.6.

    Raises ModelError when the error factor is not a finite number from 1 up.
    """

    error_factor: float
    """95th percentile divided by the median; finite, 1 or above."""
    value_is: Literal["median", "mean"] = "median"
    """What the point value of the parameter stands for."""

    def __post_init__(self) -> None:
        if not 1.0 <= self.error_factor < math.inf:
            raise ModelError(
                f"error factor {self.error_factor!r}: allowed: finite numbers from 1 on (95th "
                "percentile divided by the median)"
            )
        if self.value_is not in ("median", "mean"):
            raise ModelError(f"value_is {self.value_is!r}; allowed: mean, median")

    @property
    def sigma(self) -> float:
        """The standard deviation of the logarithm."""
        return math.log(self.error_factor) / NORMAL_95

    def quantiles(self, shares: Samples, value: float) -> Samples:
        """Return the quantiles at `shares`."""
        return self.at_scores(special().ndtri(shares), value)

    def at_scores(self, scores: Samples, value: float) -> Samples:
        """Return the values at normal scores, which are 0 at the median."""
        factors: Samples = np.exp(self.sigma * scores)
        return self._median(value) * factors

    def mean(self, value: float) -> float:
        """Return exp(sigma^2 / 2) times the median."""
        return self._median(value) * math.exp(self.sigma**2 / 2.0)

    def _median(self, value: float) -> float:
        return value if self.value_is == "median" else value * math.exp(-(self.sigma**2) / 2.0)


@dataclass(frozen=True, slots=True)
class Uniform:
    """Uniform between two bounds, in the value itself or in its logarithm.

    Raises ModelError when the bounds are not finite, not in order, or not positive for `log`.
    """

    low: float
    """Lower bound, in the unit of the parameter."""
    high: float
    """Upper bound, in the unit of the parameter; not below `low`."""
    log: bool = False
    """Whether the logarithm of the value is uniform instead of the value."""

    def __post_init__(self) -> None:
        if not -math.inf < self.low <= self.high < math.inf:
            raise ModelError(f"uniform from {self.low!r} to {self.high!r}: give low <= high")
        if self.log and self.low <= 0.0:
            raise ModelError(f"log-uniform from {self.low!r}: the bounds must be above 0")

    def quantiles(self, shares: Samples, value: float) -> Samples:  # noqa: ARG002 - absolute
        """Return the quantiles at `shares`."""
        if self.log:
            low, high = math.log(self.low), math.log(self.high)
            return np.clip(np.exp(low + (high - low) * shares), self.low, self.high)
        return self.low + (self.high - self.low) * shares

    def mean(self, value: float) -> float:  # noqa: ARG002 - absolute
        """Return the mean."""
        if not self.log or self.low == self.high:
            return (self.low + self.high) / 2.0
        return (self.high - self.low) / math.log(self.high / self.low)


@dataclass(frozen=True, slots=True)
class Beta:
    """Beta distribution of a probability, as observed demands leave it.

    Raises ModelError when one is not a finite number above zero.
    """

    alpha: float
    """First shape parameter: failures observed, plus the prior's; above 0."""
    beta: float
    """Second shape parameter: successes observed, plus the prior's; above 0."""

    def __post_init__(self) -> None:
        _check_positive("beta distribution", alpha=self.alpha, beta=self.beta)

    def quantiles(self, shares: Samples, value: float) -> Samples:  # noqa: ARG002 - absolute
        """Return the quantiles at `shares`."""
        betaincinv: Samples = special().betaincinv(self.alpha, self.beta, shares)
        return betaincinv

    def mean(self, value: float) -> float:  # noqa: ARG002 - absolute
        """Return alpha / (alpha + beta)."""
        return self.alpha / (self.alpha + self.beta)

    @property
    def variance(self) -> float:
        """The variance."""
        total = self.alpha + self.beta
        return self.alpha * self.beta / (total**2 * (total + 1.0))


@dataclass(frozen=True, slots=True)
class Gamma:
    """Gamma distribution of a rate, as observed failures leave it; its mean is shape times scale.

    Raises ModelError when one is not a finite number above zero.
    """

    shape: float
    """Shape parameter: failures observed, plus the prior's; above 0."""
    scale: float
    """Scale parameter, in the unit of the parameter: one over the time observed; above 0."""

    def __post_init__(self) -> None:
        _check_positive("gamma distribution", shape=self.shape, scale=self.scale)

    def quantiles(self, shares: Samples, value: float) -> Samples:  # noqa: ARG002 - absolute
        """Return the quantiles at `shares`."""
        samples: Samples = special().gammaincinv(self.shape, shares) * self.scale
        return samples

    def mean(self, value: float) -> float:  # noqa: ARG002 - absolute
        """Return shape times scale."""
        return self.shape * self.scale


@dataclass(frozen=True, slots=True)
class Normal:
    """Normal distribution cut to the values from zero up.

    Raises ModelError when the mean or the deviation is not a finite number above zero.
    """

    mean_value: float
    """Mean before the cut, in the unit of the parameter; above 0."""
    deviation: float
    """Standard deviation before the cut, in the unit of the parameter; above 0."""

    def __post_init__(self) -> None:
        _check_positive("normal distribution", mean=self.mean_value, deviation=self.deviation)

    def quantiles(self, shares: Samples, value: float) -> Samples:  # noqa: ARG002 - absolute
        """Return the quantiles at `shares` of the part from zero up."""
        # From the upper end, so that the part above zero keeps its digits.
        above = special().ndtr(self.mean_value / self.deviation)
        samples: Samples = self.mean_value - self.deviation * special().ndtri(
            (1.0 - shares) * above
        )
        return np.maximum(samples, 0.0)

    def mean(self, value: float) -> float:  # noqa: ARG002 - absolute
        """Return the mean of the part from zero up."""
        ratio = self.mean_value / self.deviation
        density = math.exp(-(ratio**2) / 2.0) / math.sqrt(2.0 * math.pi)
        above = math.erfc(-ratio / math.sqrt(2.0)) / 2.0
        return self.mean_value + self.deviation * density / above


def _check_positive(where: str, **values: float) -> None:
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise ModelError(f"{where}: {name} is {value!r}; give a finite number above 0")
