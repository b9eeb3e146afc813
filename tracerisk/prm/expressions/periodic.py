"""Periodically tested units, without subtraction.

The unit is available, failed in hiding, or in repair; each phase (a wait, a test) takes the shares
of the three linearly, so n equal periods are the n-th power of one 3x3 matrix of non-negative
numbers.
Semantics: Open-PSA Model Exchange Format 2.0d, section on built-ins, as SCRAM 0.16 reads it;
formulas: own derivation from the Markov graph there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.probability import Probability

Shares = tuple[float, float, float]
"""Of a unit: that it is available, failed in hiding, in repair."""
Matrix = tuple[Shares, Shares, Shares]
"""Row by row, where each share goes."""

_SNAP = 8 * 2.0**-52


@dataclass(frozen=True, slots=True)
class Tests:
    """The parameters of Open-PSA's periodic test; rates in 1/h, times in h."""

    rate: float
    interval: float
    first: float
    time: float
    repair_rate: float | None = None
    rate_in_test: float = 0.0
    failure_by_test: float = 0.0
    duration: float = 0.0
    available_in_test: bool = True
    detection: float = 1.0
    failure_at_restart: float = 0.0

    @classmethod
    def of(cls, terms: Sequence[float]) -> Tests:
        """Return the parameters that 4, 5 or 11 terms of Open-PSA stand for.

        Raises ModelError when one is out of its range.
        """
        if len(terms) == 4:
            rate, interval, first, time = terms
            return cls(rate, interval, first, time)
        if len(terms) == 5:
            rate, repair_rate, interval, first, time = terms
            return cls(rate, interval, first, time, repair_rate)
        rate, in_test, repair_rate, interval, first, by_test, duration, available = terms[:8]
        detection, at_restart, time = terms[8:]
        return cls(
            rate,
            interval,
            first,
            time,
            repair_rate,
            in_test,
            by_test,
            duration,
            bool(available),
            detection,
            at_restart,
        )

    def __post_init__(self) -> None:
        for name in ("rate", "first", "time", "repair_rate", "rate_in_test", "duration"):
            value = getattr(self, name)
            if value is not None and not 0.0 <= value < math.inf:
                raise ModelError(f"periodic test: {name} is {value!r}; allowed: 0 or more")
        for name in ("failure_by_test", "detection", "failure_at_restart"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ModelError(f"periodic test: {name} is {value!r}; allowed: 0 to 1")
        if not self.interval > 0.0:
            raise ModelError(f"periodic test: interval is {self.interval!r}; allowed: more than 0")
        if self.duration > self.interval:
            raise ModelError(
                f"periodic test: the test lasts {self.duration!r} h, longer than the interval of "
                f"{self.interval!r} h; shorten it"
            )


def unavailability(tests: Tests) -> Probability:
    """Return the probability that the unit is not available at the time, and its complement.

    With four terms, at the instant of a test it is that just before it.
    """
    if tests.time <= tests.first:
        return _exponential(tests.rate * tests.time)
    periods, rest = _periods(tests)
    if tests.repair_rate is None:
        return _exponential(tests.rate * (rest or tests.interval))
    failed = _exponential(tests.rate * tests.first)
    shares: Shares = (failed.q, failed.p, 0.0)
    wait = tests.interval - tests.duration
    period = _times(_test(tests, tests.duration), _wait(tests, wait))
    shares = _apply(shares, _power(period, periods))
    if rest <= tests.duration:
        available, hidden, repaired = _apply(shares, _test(tests, rest))
        if tests.duration and not tests.available_in_test:
            # Only what repair has just returned counts as available.
            back = _apply((0.0, 0.0, shares[2]), _test(tests, rest))[0]
            still = _apply((shares[0], shares[1], 0.0), _test(tests, rest))[0]
            return Probability(hidden + repaired + still, back)
        return Probability(hidden + repaired, available)
    shares = _apply(shares, _test(tests, tests.duration))
    available, hidden, repaired = _apply(shares, _wait(tests, rest - tests.duration))
    return Probability(hidden + repaired, available)


def _periods(tests: Tests) -> tuple[int, float]:
    """Return how many whole intervals have passed since the first test, and the rest, [h].

    The remainder is exact; one that differs from none by rounding only is none.
    """
    since = tests.time - tests.first
    rest = math.fmod(since, tests.interval)
    slack = _SNAP * since
    if tests.interval - rest <= slack or rest <= slack:
        rest = 0.0
    return round((since - rest) / tests.interval), rest


def _wait(tests: Tests, time: float) -> Matrix:
    """Return where the shares go while nothing is tested."""
    failed = _exponential(tests.rate * time)
    repair_rate = tests.repair_rate or 0.0
    in_repair = math.exp(-repair_rate * time)
    back = repaired_and_well(repair_rate, tests.rate, time)
    again = repaired_and_failed(repair_rate, tests.rate, time)
    broken = tests.failure_at_restart
    well = 1.0 - broken
    return (
        (failed.q, failed.p, 0.0),
        (0.0, 1.0, 0.0),
        (well * back, broken * (back + again) + well * again, in_repair),
    )


def _test(tests: Tests, time: float) -> Matrix:
    """Return where the shares go while a test lasts, of which `time` has passed."""
    in_test = _exponential(tests.rate_in_test * time)
    fails = tests.failure_by_test + (1.0 - tests.failure_by_test) * in_test.p
    holds = (1.0 - tests.failure_by_test) * in_test.q
    found, missed = tests.detection, 1.0 - tests.detection
    return (
        (holds, missed * fails, found * fails),
        (0.0, missed, found),
        _wait(tests, time)[2],
    )


def repaired_and_well(repair_rate: float, rate: float, time: float) -> float:
    """Return the probability of being repaired within `time` and not failed again since."""
    low, high = sorted((repair_rate, rate))
    gap = (high - low) * time
    return repair_rate * time * math.exp(-low * time) * (-math.expm1(-gap) / gap if gap else 1.0)


def repaired_and_failed(repair_rate: float, rate: float, time: float) -> float:
    """Return the probability that repair and then a new failure both happen within `time`.

    It is mu lambda t^2 times the divided difference of exp over 0, -lambda t, -mu t.
    Shifted so that all three arguments are non-negative, its series has non-negative terms only;
    where that would be long, one of the two closed forms does not cancel.
    """
    low, high = sorted((repair_rate * time, rate * time))
    if high <= 30.0:
        other = high - low
        term, power, total, count = 0.5, 1.0, 0.0, 0
        symmetric = 1.0
        while True:
            grown = total + symmetric * term
            if grown == total and count > high:
                break
            total = grown
            count += 1
            term /= count + 2
            power *= other
            symmetric = high * symmetric + power
        return low * high * math.exp(-high) * total
    if low >= 10.0:
        well = repaired_and_well(repair_rate, rate, time)
        return 1.0 - (math.exp(-repair_rate * time) + well)
    return (-high * math.expm1(-low) + low * math.expm1(-high)) / (high - low)


def _exponential(hazard: float) -> Probability:
    return Probability(-math.expm1(-hazard), math.exp(-hazard))


def _apply(shares: Shares, matrix: Matrix) -> Shares:
    first, second, third = (
        sum(share * row[column] for share, row in zip(shares, matrix, strict=True))
        for column in range(3)
    )
    return first, second, third


def _times(left: Matrix, right: Matrix) -> Matrix:
    return _apply(left[0], right), _apply(left[1], right), _apply(left[2], right)


def _power(matrix: Matrix, exponent: int) -> Matrix:
    result: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    while exponent:
        if exponent & 1:
            result = _times(result, matrix)
        matrix = _times(matrix, matrix)
        exponent >>= 1
    return result
