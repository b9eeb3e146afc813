"""Failure probabilities with 40 digits, needed to solve for the one value of a block.

Pairs (p, 1-p), and sums of positive terms only, so that 1e-200 keeps its digits.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import ParamSpec, TypeVar

_P = ParamSpec("_P")
_R = TypeVar("_R")

ZERO = Decimal(0)
ONE = Decimal(1)
_DIGITS = Context(prec=40, Emin=-(10**9), Emax=10**9)
_SERIES = Decimal("1e-6")
"""Below it, a difference from one would cost more than six digits."""
_TERMS = 8
_MOST_STEPS = 400
_CLOSE = Decimal("1e-30")


@dataclass(frozen=True, slots=True)
class Outcome:
    """A failure probability and its complement."""

    p: Decimal
    """The probability of failing."""
    q: Decimal
    """The probability of not failing, 1 - p."""

    @property
    def hazard(self) -> Decimal:
        """-ln q; infinite for certain failure."""
        if self.q == ZERO:
            return Decimal("Infinity")
        if self.p >= _SERIES:
            return -self.q.ln()
        return sum((self.p**k / k for k in range(1, _TERMS)), ZERO)

    def share(self, part: Decimal) -> Outcome:
        """Return the outcome that fails with `part` times this failure probability."""
        return Outcome(part * self.p, ONE - part + part * self.q)

    def either(self, other: Outcome) -> Outcome:
        """Return the outcome that fails where this or the independent other one does."""
        return Outcome(self.p + self.q * other.p, self.q * other.q)


NEVER = Outcome(ZERO, ONE)
SURELY = Outcome(ONE, ZERO)


def with_digits(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Make a function compute with 40 digits, whatever its caller's context."""

    @functools.wraps(function)
    def precise(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        with localcontext(_DIGITS):
            return function(*args, **kwargs)

    return precise


def after(hazard: Decimal) -> Outcome:
    """Return the outcome of a hazard: p = 1 - exp(-hazard)."""
    if hazard.is_infinite():
        return SURELY
    q = (-hazard).exp()
    if hazard >= _SERIES:
        return Outcome(ONE - q, q)
    p, term = ZERO, -ONE
    for k in range(1, _TERMS):
        term *= -hazard / k
        p += term
    return Outcome(p, q)


def at_least(threshold: int, units: Sequence[Outcome]) -> Outcome:
    """Return the outcome that fails where `threshold` or more of unlike units do."""
    counts, reached = [ONE] + [ZERO] * (threshold - 1), ZERO
    for unit in units:
        reached += counts[-1] * unit.p
        _count(counts, unit)
    return Outcome(reached, sum(counts, ZERO))


def fewer_than(threshold: int, units: Sequence[Outcome]) -> list[Decimal]:
    """Return the probabilities that 0, 1, ... `threshold` - 1 of unlike units fail."""
    counts = [ONE] + [ZERO] * (threshold - 1)
    for unit in units:
        _count(counts, unit)
    return counts


def _count(counts: list[Decimal], unit: Outcome) -> None:
    """Add one more unit."""
    for failed in range(len(counts) - 1, 0, -1):
        counts[failed] = counts[failed] * unit.q + counts[failed - 1] * unit.p
    counts[0] *= unit.q


def at_least_of_like(threshold: int, quantity: int, unit: Outcome) -> Outcome:
    """Return the outcome that fails where `threshold` or more of so many like units do."""
    if ZERO in (unit.p, unit.q):
        return unit
    odds = unit.p / unit.q
    term = unit.q**quantity
    p, q = ZERO, ZERO
    for failed in range(quantity + 1):
        if failed < threshold:
            q += term
        else:
            p += term
        term *= odds * (quantity - failed) / (failed + 1)
    return Outcome(p, q)


def solve_hazard(
    function: Callable[[Decimal], Decimal], target: Decimal, start: Decimal
) -> Decimal:
    """Return the x > 0 at which an increasing function reaches a target above 0, from a start.

    The function is close to a power of x, so the secant method runs on logarithms, within what
    is known to hold the root; where it leaves that, the interval is halved.
    """
    goal = target.ln()
    low: Decimal | None = None
    high: Decimal | None = None
    x = start.ln()
    previous: tuple[Decimal, Decimal] | None = None
    for _ in range(_MOST_STEPS):
        value = function(x.exp())
        error = value.ln() - goal if value > ZERO else Decimal("-Infinity")
        if abs(error) < _CLOSE:
            break
        if error > ZERO:
            high = x
        else:
            low = x
        following = None
        if previous is not None and error.is_finite() and error != previous[1]:
            following = x - error * (x - previous[0]) / (error - previous[1])
        previous = (x, error) if error.is_finite() else None
        if following is None or not _is_between(low, following, high):
            following = _middle(low, high)
        if following == x:
            break
        x = following
    return x.exp()


def _is_between(low: Decimal | None, x: Decimal, high: Decimal | None) -> bool:
    return (low is None or low < x) and (high is None or x < high)


def _middle(low: Decimal | None, high: Decimal | None) -> Decimal:
    if low is None:
        assert high is not None
        return high - 2
    return low + 2 if high is None else (low + high) / 2
