"""Random deviates: their mean is their point value, their quantile function samples them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.special import special
from tracerisk.prm.other_models.expressions.node import Expression

if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.node import Array


class Deviate(Expression):
    """A random quantity; its arguments are the parameters of its distribution."""

    __slots__ = ()

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles at `uniform`, in (0, 1), for arguments of the same shape.

        Raises ModelError when an argument is out of its range.
        """
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class UniformDeviate(Deviate):
    """A uniform deviate."""

    lower: Expression
    """Lower bound."""
    upper: Expression
    """Upper bound, above `lower`."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The bounds."""
        return (self.lower, self.upper)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        lower, upper = arguments
        _check_order(lower, upper)
        return lower + (upper - lower) / 2

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        lower, upper = arguments
        worst = int((upper - lower).argmin())
        _check_order(float(lower[worst]), float(upper[worst]))
        return lower + (upper - lower) * uniform


@dataclass(frozen=True, slots=True)
class NormalDeviate(Deviate):
    """A normal deviate."""

    mean: Expression
    """Mean, which is also the point value."""
    sigma: Expression
    """Standard deviation, above 0."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The mean and the standard deviation."""
        return (self.mean, self.sigma)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        _check_positive("normal", sigma=arguments[1])
        return arguments[0]

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        mean, sigma = arguments
        _check_positive("normal", sigma=float(sigma.min()))
        found: Array = mean + sigma * special().ndtri(uniform)
        return found


@dataclass(frozen=True, slots=True)
class LognormalDeviate(Deviate):
    """Lognormal, in either form of Open-PSA."""

    terms: tuple[Expression, ...]
    """Mean, error factor (quantile over median) and the level of the error factor, commonly
    0.95; or mean and standard deviation of the logarithm."""

    def __post_init__(self) -> None:
        if len(self.terms) not in (2, 3):
            raise ModelError(f"a lognormal deviate has {len(self.terms)} terms; allowed: 2 or 3")

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The terms."""
        return self.terms

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        if len(arguments) == 3:
            _check_error_factor(*arguments)
            return arguments[0]
        mu, sigma = arguments
        _check_positive("lognormal", sigma=sigma)
        try:
            return math.exp(mu + sigma**2 / 2)
        except OverflowError as error:
            raise ModelError(
                f"the mean of a lognormal deviate of mu {mu!r} and sigma {sigma!r} is too large "
                "for a number; give smaller ones"
            ) from error

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        if len(arguments) == 3:
            mean, factor, level = arguments
            for worst in {int(mean.argmin()), int(factor.argmin()), int(level.argmin())}:
                _check_error_factor(float(mean[worst]), float(factor[worst]), float(level[worst]))
            sigma = np.log(factor) / special().ndtri(level)
            mu = np.log(mean) - sigma**2 / 2
        else:
            mu, sigma = arguments
            _check_positive("lognormal", sigma=float(sigma.min()))
        found: Array = np.exp(mu + sigma * special().ndtri(uniform))
        return found


@dataclass(frozen=True, slots=True)
class GammaDeviate(Deviate):
    """A gamma deviate, whose mean is shape times scale."""

    shape: Expression
    """Shape parameter, above 0."""
    scale: Expression
    """Scale parameter, above 0."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The shape and the scale."""
        return (self.shape, self.scale)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        shape, scale = arguments
        _check_positive("gamma", shape=shape, scale=scale)
        return shape * scale

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        shape, scale = arguments
        _check_positive("gamma", shape=float(shape.min()), scale=float(scale.min()))
        found: Array = scale * special().gammaincinv(shape, uniform)
        return found


@dataclass(frozen=True, slots=True)
class BetaDeviate(Deviate):
    """A beta deviate, with values from 0 to 1."""

    alpha: Expression
    """First shape parameter, above 0."""
    beta: Expression
    """Second shape parameter, above 0."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The two shapes."""
        return (self.alpha, self.beta)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        alpha, beta = arguments
        _check_positive("beta", alpha=alpha, beta=beta)
        return alpha / (alpha + beta)

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        alpha, beta = arguments
        _check_positive("beta", alpha=float(alpha.min()), beta=float(beta.min()))
        found: Array = special().betaincinv(alpha, beta, uniform)
        return found


@dataclass(frozen=True, slots=True)
class Histogram(Deviate):
    """A deviate with constant density within each bin."""

    boundaries: tuple[Expression, ...]
    """Bounds of the bins in ascending order, (n_bins + 1,)."""
    weights: tuple[Expression, ...]
    """Relative probability of each bin, (n_bins,), not negative and not all 0."""

    def __post_init__(self) -> None:
        if not self.weights or len(self.boundaries) != len(self.weights) + 1:
            raise ModelError(
                f"a histogram has {len(self.weights)} weights and {len(self.boundaries)} "
                "boundaries; give at least one weight, and one more boundary than weights"
            )

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The boundaries, then the weights."""
        return (*self.boundaries, *self.weights)

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:  # noqa: ARG002
        """Return the mean."""
        bounds, weights = arguments[: len(self.boundaries)], arguments[len(self.boundaries) :]
        _check_histogram(bounds, weights)
        middles = [low + (high - low) / 2 for low, high in pairwise(bounds)]
        return math.fsum(map(math.prod, zip(middles, weights, strict=True))) / math.fsum(weights)

    def quantiles(self, arguments: Sequence[Array], uniform: Array) -> Array:
        """Return the quantiles."""
        bounds = np.array(arguments[: len(self.boundaries)])
        weights = np.array(arguments[len(self.boundaries) :])
        for worst in {int(np.diff(bounds, axis=0).min(0).argmin()), int(weights.min(0).argmin())}:
            _check_histogram(bounds[:, worst].tolist(), weights[:, worst].tolist())
        draws = np.arange(len(uniform))
        ends = np.cumsum(weights, axis=0)
        reached = uniform * ends[-1]
        bins = np.minimum((ends <= reached).sum(axis=0), len(weights) - 1)
        share = 1.0 - (ends[bins, draws] - reached) / np.where(
            weights[bins, draws] > 0, weights[bins, draws], 1.0
        )
        low, high = bounds[bins, draws], bounds[bins + 1, draws]
        found: Array = low + (high - low) * np.clip(share, 0.0, 1.0)
        return found


def _check_order(lower: float, upper: float) -> None:
    if not lower < upper:
        raise ModelError(
            f"a uniform deviate from {lower!r} to {upper!r}; give a greater upper bound"
        )


def _check_positive(kind: str, **found: float) -> None:
    for name, value in found.items():
        if not value > 0.0:
            raise ModelError(f"{kind} deviate: {name} is {value!r}; allowed: more than 0")


def _check_error_factor(mean: float, factor: float, level: float) -> None:
    _check_positive("lognormal", mean=mean)
    if not factor > 1.0:
        raise ModelError(f"lognormal deviate: the error factor is {factor!r}; allowed: more than 1")
    if not 0.5 < level < 1.0:
        raise ModelError(
            f"lognormal deviate: the level of the error factor is {level!r}; "
            "allowed: more than 0.5, less than 1"
        )


def _check_histogram(bounds: Sequence[float], weights: Sequence[float]) -> None:
    if not all(low < high for low, high in pairwise(bounds)):
        shown = ", ".join(map(repr, bounds))
        raise ModelError(
            f"a histogram with the boundaries {shown}; each must exceed the one before"
        )
    if not (all(weight >= 0 for weight in weights) and any(weights)):
        shown = ", ".join(map(repr, weights))
        raise ModelError(
            f"a histogram with the weights {shown}; no weight may be negative, and not all may be 0"
        )
