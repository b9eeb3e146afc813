"""The failure laws of Open-PSA as expressions of their parameters.

Each gives a probability and its complement as sums and products of non-negative numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.errors import ModelError
from tracerisk.prm.expressions import periodic
from tracerisk.prm.expressions.node import Expression
from tracerisk.prm.probability import Probability

if TYPE_CHECKING:
    from tracerisk.prm.expressions.node import Array


class _Law(Expression):
    """A law: its value is the first half of its probability."""

    __slots__ = ()

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

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:  # noqa: ARG002
        """Return the probability and its complement."""
        rate, time = arguments
        _check_not_negative("exponential", rate=rate, time=time)
        return Probability(-math.expm1(-rate * time), math.exp(-rate * time))

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:  # noqa: ARG002
        """Return the probabilities."""
        import numpy as np

        rate, time = arguments
        _check_not_negative("exponential", rate=float(rate.min()), time=float(time.min()))
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

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:  # noqa: ARG002
        """Return the unavailability and its complement.

        With r = lambda + mu: p = gamma exp(-r t) + lambda/r (1 - exp(-r t)), which is Open-PSA's
        formula with its terms gathered so that none is subtracted.
        """
        on_demand, rate, repair_rate, time = arguments
        _check_not_negative("GLM", rate=rate, repair_rate=repair_rate, time=time)
        start = _probability("GLM", "on_demand", on_demand)
        total = rate + repair_rate
        if total == 0:
            return start
        kept, left = math.exp(-total * time), -math.expm1(-total * time)
        return Probability(
            start.p * kept + rate / total * left, start.q * kept + repair_rate / total * left
        )

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the unavailabilities."""
        import numpy as np

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

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:  # noqa: ARG002
        """Return the probability and its complement."""
        scale, shape, shift, time = arguments
        _check_positive("Weibull", scale=scale, shape=shape)
        _check_not_negative("Weibull", shift=shift, time=time)
        if time <= shift:
            return Probability(0.0, 1.0)
        try:
            hazard = math.pow((time - shift) / scale, shape)
        except OverflowError:
            return Probability(1.0, 0.0)
        return Probability(-math.expm1(-hazard), math.exp(-hazard))

    def values(self, arguments: Sequence[Array], mission_time_h: float, size: int) -> Array:
        """Return the probabilities."""
        import numpy as np

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

    def probability(self, arguments: Sequence[float], mission_time_h: float) -> Probability:  # noqa: ARG002
        """Return the unavailability and its complement; the formulas are in `periodic`."""
        return periodic.unavailability(periodic.Tests.of(arguments))


def _probability(law: str, name: str, value: float) -> Probability:
    if not 0.0 <= value <= 1.0:
        raise ModelError(f"{law}: {name} is {value!r}; allowed: 0 to 1")
    return Probability.of(value)


def _check_not_negative(law: str, **found: float) -> None:
    for name, value in found.items():
        if not value >= 0.0:
            raise ModelError(f"{law}: {name} is {value!r}; allowed: 0 or more")


def _check_positive(law: str, **found: float) -> None:
    for name, value in found.items():
        if not value > 0.0:
            raise ModelError(f"{law}: {name} is {value!r}; allowed: more than 0")
