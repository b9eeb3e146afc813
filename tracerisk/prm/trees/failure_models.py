"""Failure models: what gives a basic event its probability over a mission.

Every model returns the pair (p, 1-p), each half to a relative error of a few units in the last
place (of `PeriodicTest`: 1e-12): exponentials of small numbers go through `expm1` and `log1p`,
and sums have terms of one sign only.
Times are in hours, rates per hour.

Sources: "Open-PSA Model Exchange Format" 2.0d, chapter "Stochastic layer", built-ins;
M. Rausand, A. Hoyland, "System Reliability Theory", 2nd ed. (2004), chapter 2; IEC 61508-6.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.quantities import (
    check_count,
    check_mission_time,
    check_not_negative,
    check_positive,
    check_share,
)
from tracerisk.prm.trees.tested_component import PeriodicTest

__all__ = [
    "GLM",
    "Constant",
    "Erlang",
    "Exponential",
    "Lognormal",
    "PerDemand",
    "PeriodicTest",
    "Weibull",
]

NEVER = Probability(0.0, 1.0)
_MOST_PHASES = 10_000


@dataclass(frozen=True, slots=True)
class Constant:
    """A probability that is the same for every mission.

    Raises ModelError when `p` is not in [0, 1].
    """

    needs_mission_time: ClassVar[bool] = False
    """False: the probability holds without a mission time."""

    p: float
    """Probability of failure in a mission, in [0, 1]."""

    def __post_init__(self) -> None:
        check_share("p", self.p)

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability; the mission's length is of no account, [h]."""
        check_mission_time(mission_time_h)
        return Probability.of(self.p)


@dataclass(frozen=True, slots=True)
class Exponential:
    """A constant failure rate: 1 - exp(-rate t), without repair.

    Source: Rausand and Hoyland, chapter 2.
    Raises ModelError when the rate is negative or not finite.
    """

    rate: float
    """Failure rate [1/h], not negative."""

    def __post_init__(self) -> None:
        check_not_negative("rate", self.rate, "1/h")

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability of a failure within the mission, [h]."""
        check_mission_time(mission_time_h)
        return of_hazard(self.rate * mission_time_h)


@dataclass(frozen=True, slots=True)
class Erlang:
    """So many phases of one constant rate, the last of which ends in failure.

    Source: Rausand and Hoyland, chapter 2.
    Raises ModelError when the rate is negative or `phases` not a whole number from 1 to 10,000.
    """

    rate: float
    """Rate at which each phase ends [1/h], not negative."""
    phases: int
    """Number of phases until failure, 1 to 10,000."""

    def __post_init__(self) -> None:
        check_not_negative("rate", self.rate, "1/h")
        check_count("phases", self.phases, least=1)
        if self.phases > _MOST_PHASES:
            raise ModelError(f"{self.phases} phases; allowed: 1 to {_MOST_PHASES}")

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that all phases end within the mission, [h]."""
        check_mission_time(mission_time_h)
        mean = self.rate * mission_time_h
        if mean == 0.0:
            return NEVER
        if mean > 2.0 * self.phases + 6_000.0:
            # Fewer events than phases: below exp(-(mean - phases)^2 / (2 mean)), less than 1e-320.
            return Probability(1.0, 0.0)
        # Poisson's terms, relative to the greatest: fewer than so many events, and the others.
        peak = int(mean)
        fewer = more = 0.0
        term = 1.0
        for count in range(peak, -1, -1):
            if count < self.phases:
                fewer += term
            else:
                more += term
            term *= count / mean
            if term == 0.0:
                break
        term, count = mean / (peak + 1), peak + 1
        while term > 0.0 and (count <= self.phases or term > 1e-18 * more):
            if count < self.phases:
                fewer += term
            else:
                more += term
            count += 1
            term *= mean / count
        return Probability(more / (more + fewer), fewer / (more + fewer))


@dataclass(frozen=True, slots=True)
class Lognormal:
    """A time to failure whose logarithm is normal.

    Source: Rausand and Hoyland, chapter 2.
    Raises ModelError when the deviation is not positive or the mean not finite.
    """

    mean: float
    """Mean of the natural logarithm of the time to failure in hours."""
    deviation: float
    """Standard deviation of the natural logarithm of the time, above 0."""

    def __post_init__(self) -> None:
        check_positive("deviation", self.deviation, "")
        check_not_negative("the size of the mean", abs(self.mean), "")

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability of a failure within the mission, [h]."""
        check_mission_time(mission_time_h)
        if mission_time_h == 0.0:
            return NEVER
        score = (math.log(mission_time_h) - self.mean) / self.deviation / math.sqrt(2.0)
        return Probability(math.erfc(-score) / 2, math.erfc(score) / 2)


@dataclass(frozen=True, slots=True)
class Weibull:
    """A failure rate that grows or falls with age: Weibull's law.

    The accumulated hazard at age x is ((x - location) / scale)^shape, zero before `location_h`.
    The probability is conditional on survival until the mission starts,
    1 - exp(-(H(age + t) - H(age))).
    Source: Rausand and Hoyland, chapter 2; with age 0, the Open-PSA built-in `Weibull`.

    Raises ModelError when scale or shape are not positive, or location or age negative.
    """

    scale_h: float
    """Characteristic life after `location_h` [h], above 0."""
    shape: float
    """Shape parameter, above 0; the failure rate grows with age where it is above 1."""
    location_h: float = 0.0
    """Age before which no failure happens [h]."""
    age_h: float = 0.0
    """Age of the unit when the mission starts [h]."""

    def __post_init__(self) -> None:
        check_positive("scale_h", self.scale_h, "h")
        check_positive("shape", self.shape, "")
        check_not_negative("location_h", self.location_h, "h")
        check_not_negative("age_h", self.age_h, "h")

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability of a failure within the mission, [h]."""
        check_mission_time(mission_time_h)
        if self.age_h <= self.location_h:
            # One rounding only: age, mission and location may nearly cancel.
            exposed = math.fsum((self.age_h, mission_time_h, -self.location_h))
            return (
                NEVER if exposed <= 0.0 else of_hazard(_power(exposed / self.scale_h, self.shape))
            )
        worn = self.age_h - self.location_h
        # H(age + t) - H(age) = H(age) ((1 + t / worn)^shape - 1), in which nothing cancels.
        try:
            growth = math.expm1(self.shape * math.log1p(mission_time_h / worn))
        except OverflowError:
            growth = math.inf
        before = _power(worn / self.scale_h, self.shape)
        return of_hazard(before * growth if growth > 0.0 else 0.0)


@dataclass(frozen=True, slots=True)
class GLM:
    """A unit that fails at demand, fails while it runs, and is repaired: gamma, lambda, mu.

    It is down at time t with lambda/(lambda+mu) (1 - exp(-(lambda+mu) t)) + gamma
    exp(-(lambda+mu) t).
    Source: the Open-PSA built-in `GLM`; the form without differences is own derivation.

    Raises ModelError when gamma is not a probability or a rate negative.
    """

    failure_on_demand: float
    """Probability gamma that the unit fails at the start of the mission."""
    failure_rate: float
    """Failure rate lambda while the unit runs [1/h]."""
    repair_rate: float
    """Repair rate mu while the unit is down [1/h]."""

    def __post_init__(self) -> None:
        check_share("failure_on_demand", self.failure_on_demand)
        check_not_negative("failure_rate", self.failure_rate, "1/h")
        check_not_negative("repair_rate", self.repair_rate, "1/h")

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that the unit is down at the end of the mission, [h]."""
        check_mission_time(mission_time_h)
        # Halved, so that the sum of two finite rates is finite.
        half = self.failure_rate / 2 + self.repair_rate / 2
        if half == 0.0:
            return Probability.of(self.failure_on_demand)
        changed, kept = of_hazard(2 * (half * mission_time_h))
        failing = self.failure_rate / 2 / half
        repaired = self.repair_rate / 2 / half
        return Probability(
            failing * changed + self.failure_on_demand * kept,
            repaired * changed + (1.0 - self.failure_on_demand) * kept,
        )


@dataclass(frozen=True, slots=True)
class PerDemand:
    """Independent demands in a mission, each of which may fail: 1 - (1 - p)^demands.

    Raises ModelError when `p` is not a probability or `demands` not a whole number from 0 on.
    """

    needs_mission_time: ClassVar[bool] = False
    """False: the probability holds without a mission time."""

    p: float
    """Probability of failure per demand, in [0, 1]."""
    demands: int = 1
    """Number of demands in a mission, 0 or more."""

    def __post_init__(self) -> None:
        check_share("p", self.p)
        check_count("demands", self.demands)

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability that at least one demand fails, whatever the mission's length."""
        check_mission_time(mission_time_h)
        if self.demands == 0:
            return NEVER
        if self.demands == 1 or self.p == 1.0:
            return Probability.of(self.p)
        return of_hazard(-self.demands * math.log1p(-self.p))


def of_hazard(hazard: float) -> Probability:
    """Return the pair of 1 - exp(-hazard), for an accumulated hazard from 0 to infinity."""
    if math.isnan(hazard):
        raise ModelError("the accumulated hazard is not a number; give less extreme parameters")
    return Probability(-math.expm1(-hazard), math.exp(-hazard))


def _power(base: float, exponent: float) -> float:
    try:
        return math.pow(base, exponent)
    except OverflowError:
        return math.inf
