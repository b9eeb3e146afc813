"""A unit whose failures stay hidden until a periodic test finds them.

The unit is up, failed and hidden, or in repair; between tests and within one it is a Markov chain.
Its three chances are carried from phase to phase by matrices without a negative entry, the hours
that it was up and down beside them, and many periods by repeated squaring: nothing cancels, and a
million periods take twenty products.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.numbers.quantities import (
    check_mission_time,
    check_not_negative,
    check_positive,
    check_share,
)

Matrix = tuple[tuple[float, ...], ...]

UP, HIDDEN, REPAIR, HOURS_UP, HOURS_DOWN = range(5)
"""The chances of the three states, then the hours spent up and down so far."""


@dataclass(frozen=True, slots=True)
class PeriodicTest:
    """Hidden failures found by periodic tests and then repaired.

    An end within rounding of a test counts as the moment before it.
    Source: the Open-PSA built-in `periodic-test`, its forms with 4, 5 and 11 arguments, see
    `of_open_psa`; the solution is own derivation. Relative error below 1e-12 for a thousand
    periods, and growing with their number beyond.

    Raises ModelError when a figure is outside its range or a test lasts longer than the interval.
    """

    rate: float
    """Rate of hidden failures between tests [1/h]."""
    interval_h: float
    """Time from the start of a test to the start of the next [h], above 0."""
    first_test_h: float = 0.0
    """Time of the first test [h]."""
    repair_rate: float = math.inf
    """Rate of repair after a failure is detected [1/h]; infinite: at once."""
    rate_in_test: float = 0.0
    """Failure rate during a test [1/h]."""
    failure_at_test: float = 0.0
    """Probability that a test breaks a working unit."""
    test_duration_h: float = 0.0
    """Duration of a test [h], at most `interval_h`."""
    available_in_test: bool = True
    """Whether the unit stays in service during a test."""
    detection: float = 1.0
    """Probability that a test detects a failure."""
    bad_restart: float = 0.0
    """Probability that a repaired unit is restarted badly, and stays failed unnoticed."""
    averaged: bool = False
    """Whether the probability is the mean over the mission (average probability of failure on
    demand, IEC 61508-6, annex B) instead of the value at its end."""

    def __post_init__(self) -> None:
        check_not_negative("rate", self.rate, "1/h")
        check_positive("interval_h", self.interval_h, "h")
        check_not_negative("first_test_h", self.first_test_h, "h")
        if self.repair_rate != math.inf:
            check_not_negative("repair_rate", self.repair_rate, "1/h")
        check_not_negative("rate_in_test", self.rate_in_test, "1/h")
        check_share("failure_at_test", self.failure_at_test)
        check_not_negative("test_duration_h", self.test_duration_h, "h")
        check_share("detection", self.detection)
        check_share("bad_restart", self.bad_restart)
        if self.test_duration_h > self.interval_h:
            raise ModelError(
                f"test_duration_h is {self.test_duration_h!r} h, longer than the interval of "
                f"{self.interval_h!r} h between tests; make it shorter"
            )

    @classmethod
    def of_open_psa(cls, arguments: Sequence[float]) -> PeriodicTest:
        """Return the model of the arguments of Open-PSA's `periodic-test`, without the last, time.

        They are lambda, tau, theta; or lambda, mu, tau, theta; or lambda, lambda*, mu, tau, theta,
        gamma, pi, x, sigma, omega.
        Raises ModelError when there is another number of them.
        """
        if len(arguments) == 3:
            rate, interval, first = arguments
            return cls(rate, interval, first)
        if len(arguments) == 4:
            rate, repair, interval, first = arguments
            return cls(rate, interval, first, repair)
        if len(arguments) == 10:
            rate, in_test, repair, interval, first, at_test, lasts, serves, finds, bad = arguments
            return cls(
                rate,
                interval,
                first,
                repair,
                in_test,
                at_test,
                lasts,
                serves != 0.0,
                finds,
                bad,
            )
        raise ModelError(
            f"a periodic test with {len(arguments) + 1} arguments; allowed: 4, 5 or 11"
        )

    def probability(self, mission_time_h: float) -> Probability:
        """Return the probability of being down at the end, or the mean over the mission, [h]."""
        check_mission_time(mission_time_h)
        if self.averaged and mission_time_h == 0.0:
            return Probability(0.0, 1.0)
        chances: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 0.0)
        chances = _after(chances, self._waiting(min(mission_time_h, self.first_test_h)))
        if mission_time_h > self.first_test_h:
            periods, rest = self._split(mission_time_h - self.first_test_h)
            period = _times(
                self._testing(self.test_duration_h, ends=True),
                self._waiting(self.interval_h - self.test_duration_h),
            )
            chances = _after(chances, _power(period, periods))
            if rest > 0.0:
                inside = rest <= self.test_duration_h
                test = self._testing(min(rest, self.test_duration_h), ends=not inside)
                chances = _after(chances, test)
                if not inside:
                    chances = _after(chances, self._waiting(rest - self.test_duration_h))
        if self.averaged:
            hours = chances[HOURS_UP] + chances[HOURS_DOWN]
            return Probability(chances[HOURS_DOWN] / hours, chances[HOURS_UP] / hours)
        return Probability(chances[HIDDEN] + chances[REPAIR], chances[UP])

    def _split(self, tested_h: float) -> tuple[int, float]:
        """Return the whole periods in the hours since the first test, and the hours left."""
        rest = math.fmod(tested_h, self.interval_h)
        periods = round((tested_h - rest) / self.interval_h)
        near = 4 * math.ulp(tested_h)
        if rest <= near:
            return periods, 0.0
        if self.interval_h - rest <= near:
            return periods + 1, 0.0
        return periods, rest

    def _waiting(self, hours: float) -> Matrix:
        """Return what a phase between tests makes of each state."""
        failing = self.rate * hours
        survived = math.exp(-failing)
        hidden = (0.0, 1.0, 0.0, 0.0, hours)
        up = (
            survived,
            -math.expm1(-failing),
            0.0,
            hours * _mean_survival(failing),
            hours * failing * _both(failing, 0.0),
        )
        return (up, hidden, self._repairing(hours, failing), *_TALLIES)

    def _testing(self, hours: float, *, ends: bool) -> Matrix:
        """Return what a test makes of each state; without its end nothing is found yet."""
        failing = self.rate_in_test * hours
        good = 1.0 - self.failure_at_test
        kept = good * math.exp(-failing)
        lost = self.failure_at_test + good * -math.expm1(-failing)
        served = good * hours * _mean_survival(failing) if self.available_in_test else 0.0
        missed = (
            self.failure_at_test * hours + good * hours * failing * _both(failing, 0.0)
            if self.available_in_test
            else hours
        )
        repair = self._repairing(hours, self.rate * hours)
        if not ends:
            # A unit that the test takes out of service is down until its end.
            now = (kept, lost) if self.available_in_test else (0.0, 1.0)
            return (
                (*now, 0.0, served, missed),
                (0.0, 1.0, 0.0, 0.0, hours),
                repair,
                *_TALLIES,
            )
        unseen, to_up, to_repair = 1.0 - self.detection, 0.0, self.detection
        if self.repair_rate == math.inf:
            unseen += self.detection * self.bad_restart
            to_up, to_repair = self.detection * (1.0 - self.bad_restart), 0.0
        return (
            (kept + lost * to_up, lost * unseen, lost * to_repair, served, missed),
            (to_up, unseen, to_repair, 0.0, hours),
            repair,
            *_TALLIES,
        )

    def _repairing(self, hours: float, failing: float) -> tuple[float, ...]:
        """Return where a unit in repair is after some hours, by the hazard once it is up again."""
        if self.repair_rate == math.inf:
            # Repair takes no time: no unit is ever in this state.
            return (0.0, 0.0, 1.0, 0.0, hours)
        repair = self.repair_rate * hours
        bad, well = self.bad_restart, 1.0 - self.bad_restart
        both, done = _both(failing, repair), _both(0.0, repair)
        up = repair * math.exp(-min(failing, repair)) * _mean_survival(abs(repair - failing))
        return (
            well * up,
            bad * -math.expm1(-repair) + well * failing * repair * both,
            math.exp(-repair),
            well * hours * repair * both,
            hours * (_mean_survival(repair) + repair * (bad * done + well * max(done - both, 0.0))),
        )


_TALLIES = ((0.0, 0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 0.0, 1.0))


def _mean_survival(hazard: float) -> float:
    """Return (1 - exp(-x)) / x, the mean of exp(-x s) over s from 0 to 1."""
    return -math.expm1(-hazard) / hazard if hazard > 0.0 else 1.0


def _both(one: float, other: float) -> float:
    """Return P / (a b), P the chance that two phases with the hazards a and b both end in turn.

    P = 1 - (b exp(-a) - a exp(-b)) / (b - a); the quotient is 1/2 where both are 0.
    """
    less, more = sorted((one, other))
    if more > 1.0:
        head = math.exp(-less) * _mean_survival(more - less)
        return (_mean_survival(less) - head) / more
    # The series of the second divided difference of exp(-x) at 0, a and b.
    total, symmetric, power, factorial = 0.5, 1.0, 1.0, 2.0
    for degree in range(1, 25):
        power *= -less
        symmetric = -more * symmetric + power
        factorial *= degree + 2
        total += symmetric / factorial
    return total


def _after(chances: Sequence[float], matrix: Matrix) -> tuple[float, ...]:
    return tuple(
        math.fsum(chance * row[column] for chance, row in zip(chances, matrix, strict=True))
        for column in range(len(matrix))
    )


def _times(first: Matrix, second: Matrix) -> Matrix:
    """Return the product, the three chances of each state summing to one again."""
    rows = [_after(row, second) for row in first]
    for state in (UP, HIDDEN, REPAIR):
        total = math.fsum(rows[state][:HOURS_UP])
        rows[state] = (*(chance / total for chance in rows[state][:HOURS_UP]), *rows[state][3:])
    return tuple(rows)


def _power(matrix: Matrix, exponent: int) -> Matrix:
    result: Matrix = tuple(
        tuple(float(row == column) for column in range(len(matrix))) for row in range(len(matrix))
    )
    while exponent:
        if exponent & 1:
            result = _times(result, matrix)
        matrix = _times(matrix, matrix)
        exponent >>= 1
    return result
