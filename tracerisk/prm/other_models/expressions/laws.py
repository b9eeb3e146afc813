"""The failure laws of Open-PSA as expressions of their parameters.

What each gives is computed by its failure model, see `tracerisk.prm.trees.failure_models`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.expressions.node import Expression
from tracerisk.prm.trees import failure_models
from tracerisk.prm.trees.events import FailureModel

if TYPE_CHECKING:
    from tracerisk.prm.other_models.expressions.node import Array


class _Law(Expression):
    """A law, whose last argument is the time, [h]; its value is that of a failure model."""

    __slots__ = ()

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model of the arguments but the time."""
        raise NotImplementedError

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:  # noqa: ARG002
        """Return the probability and its complement."""
        try:
            return self.model(arguments[:-1]).probability(arguments[-1])
        except ModelError as error:
            name = type(self).__name__
            raise ModelError(f"{name}: {error.message}", error.location) from error

    def value(self, arguments: Sequence[float], mission_time_h: float) -> float:
        """Return the probability."""
        return self.probability(arguments, mission_time_h).p


@dataclass(frozen=True, slots=True)
class Exponential(_Law):
    """Failure within `time` [h] at a constant `rate` [1/h]: 1 - exp(-rate time)."""

    rate: Expression
    time: Expression

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The rate and the time."""
        return (self.rate, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.Exponential(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the probabilities."""
        from tracerisk.prm.numbers.arrays import np

        rate, time = arguments
        if (np.minimum(rate, time) < 0).any():
            return Expression.values(self, arguments, mission_time_h, size)
        found: Array = -np.expm1(-rate * time)
        return found


@dataclass(frozen=True, slots=True)
class Glm(_Law):
    """Unavailability at `time` of a unit that fails and is repaired at constant rates [1/h].

    `on_demand` is its unavailability at time 0 (gamma, lambda and mu of Open-PSA's GLM).
    """

    on_demand: Expression
    rate: Expression
    repair_rate: Expression
    time: Expression

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The four, in Open-PSA's order."""
        return (self.on_demand, self.rate, self.repair_rate, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.GLM(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the unavailabilities."""
        from tracerisk.prm.numbers.arrays import np

        on_demand, rate, repair_rate, time = arguments
        total = rate + repair_rate
        if (np.minimum.reduce([*arguments, 1 - on_demand]) < 0).any() or not total.all():
            return Expression.values(self, arguments, mission_time_h, size)
        found: Array = on_demand * np.exp(-total * time) - rate / total * np.expm1(-total * time)
        return found


@dataclass(frozen=True, slots=True)
class Weibull(_Law):
    """Failure within `time`: 1 - exp(-((time - shift) / scale)^shape), 0 up to `shift` [h]."""

    scale: Expression
    shape: Expression
    shift: Expression
    time: Expression

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The four, in Open-PSA's order."""
        return (self.scale, self.shape, self.shift, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.Weibull(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the probabilities."""
        from tracerisk.prm.numbers.arrays import np

        scale, shape, shift, time = arguments
        if (np.minimum(scale, shape) <= 0).any() or (np.minimum(shift, time) < 0).any():
            return Expression.values(self, arguments, mission_time_h, size)
        with np.errstate(over="ignore"):
            found: Array = -np.expm1(-np.power(np.maximum(time - shift, 0.0) / scale, shape))
        return found


@dataclass(frozen=True, slots=True)
class PeriodicTest(_Law):
    """Unavailability at the mission's end of a unit whose failures only tests reveal.

    `terms` are Open-PSA's, of which there are
    4: rate, interval of tests, time of the first test, time (repair takes no time);
    5: rate, repair rate, interval, first test, time (the test takes no time);
    11: rate, rate during the test, repair rate, interval, first test, failure due to the test,
    duration of the test, whether it is available while tested, detection by the test, failure at
    restart after repair, time.
    Rates in 1/h, times in h.
    """

    terms: tuple[Expression, ...]

    def __post_init__(self) -> None:
        if len(self.terms) not in (4, 5, 11):
            raise ModelError(f"a periodic test has {len(self.terms)} terms; allowed: 4, 5 or 11")

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The terms."""
        return self.terms

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.PeriodicTest.of_open_psa(arguments)
