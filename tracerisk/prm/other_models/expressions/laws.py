"""The failure laws of Open-PSA as expressions of their parameters.

What each gives is computed by its failure model, see `tracerisk.prm.trees.failure_models`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np
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
    """Failure at a constant rate: 1 - exp(-rate time)."""

    rate: Expression
    """Failure rate [1/h]."""
    time: Expression
    """Time in operation [h]."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The rate and the time."""
        return (self.rate, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.Exponential(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the probabilities."""
        rate, time = arguments
        if (np.minimum(rate, time) < 0).any():
            return Expression.values(self, arguments, mission_time_h, size)
        array: Array = -np.expm1(-rate * time)
        return array


@dataclass(frozen=True, slots=True)
class Glm(_Law):
    """Unavailability of a unit that fails and is repaired at constant rates: Open-PSA's GLM."""

    on_demand: Expression
    """Unavailability at time 0 (gamma)."""
    rate: Expression
    """Failure rate (lambda) [1/h]."""
    repair_rate: Expression
    """Repair rate (mu) [1/h]."""
    time: Expression
    """Time at which the unit is needed [h]."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The four, in Open-PSA's order."""
        return (self.on_demand, self.rate, self.repair_rate, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.GLM(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the unavailabilities."""
        on_demand, rate, repair_rate, time = arguments
        total = rate + repair_rate
        if (np.minimum.reduce([*arguments, 1 - on_demand]) < 0).any() or not total.all():
            return Expression.values(self, arguments, mission_time_h, size)
        array: Array = on_demand * np.exp(-total * time) - rate / total * np.expm1(-total * time)
        return array


@dataclass(frozen=True, slots=True)
class Weibull(_Law):
    """Failure by Weibull's law: 1 - exp(-((time - shift) / scale)^shape), 0 up to `shift`."""

    scale: Expression
    """Characteristic life after `shift` [h]."""
    shape: Expression
    """Shape parameter, above 0."""
    shift: Expression
    """Age before which no failure happens [h]."""
    time: Expression
    """Age at the end [h]."""

    @property
    def arguments(self) -> tuple[Expression, ...]:
        """The four, in Open-PSA's order."""
        return (self.scale, self.shape, self.shift, self.time)

    def model(self, arguments: Sequence[float]) -> FailureModel:
        """Return the failure model."""
        return failure_models.Weibull(*arguments)

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the probabilities."""
        scale, shape, shift, time = arguments
        if (np.minimum(scale, shape) <= 0).any() or (np.minimum(shift, time) < 0).any():
            return Expression.values(self, arguments, mission_time_h, size)
        with np.errstate(over="ignore"):
            array: Array = -np.expm1(-np.power(np.maximum(time - shift, 0.0) / scale, shape))
        return array


@dataclass(frozen=True, slots=True)
class PeriodicTest(_Law):
    """Unavailability at the mission's end of a unit whose failures only tests reveal.

    Open-PSA has forms of
    4 terms: rate, interval of tests, time of the first test, time (repair takes no time);
    5 terms: rate, repair rate, interval, first test, time (the test takes no time);
    11 terms: rate, rate during the test, repair rate, interval, first test, failure due to the
    test, duration of the test, whether it is available while tested, detection by the test, failure
    at restart after repair, time.
    """

    terms: tuple[Expression, ...]
    """The terms of one of these forms, rates in [1/h], times in [h]."""

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
