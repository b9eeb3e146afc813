"""How many of equal independent units fail: probabilities and tails without a subtraction."""

from __future__ import annotations

import math
from functools import lru_cache

_EXACT_POWER = 16
_EXACT_CHOICE = 1_000


@lru_cache(maxsize=65_536)
def failure_counts(units: int, p: float, most: int) -> tuple[float, ...]:
    """Return the probabilities that 0, 1, ... up to `most` of the units fail."""
    return tuple(_count(units, p, failed) for failed in range(min(units, most) + 1))


@lru_cache(maxsize=65_536)
def failure_tails(units: int, p: float, most: int) -> tuple[float, ...]:
    """Return the probabilities that at least 1, 2, ... up to `most` of the units fail."""
    most = min(units, most)
    if most < 1:
        return ()
    tails = [_tail(units, p, most)]
    for failed in range(most - 1, 0, -1):
        tails.append(tails[-1] + _count(units, p, failed))
    return tuple(reversed(tails))


def _tail(units: int, p: float, least: int) -> float:
    total = 0.0
    for failed in range(least, units + 1):
        term = _count(units, p, failed)
        total += term
        # Past the mean the terms fall faster and faster.
        if failed > units * abs(p) and abs(term) < 1e-20 * abs(total):
            break
    return total


def _count(units: int, p: float, failed: int) -> float:
    working = units - failed
    if p in (0.0, 1.0):
        return 1.0 if failed == units * p else 0.0
    if isinstance(p, complex):
        return math.comb(units, failed) * p**failed * (1.0 - p) ** working
    if units > _EXACT_CHOICE:
        choices = math.lgamma(units + 1) - math.lgamma(failed + 1) - math.lgamma(working + 1)
        return math.exp(choices + failed * math.log(p) + working * math.log1p(-p))
    survival = (1.0 - p) ** working if working <= _EXACT_POWER else _power(p, working)
    return math.comb(units, failed) * p**failed * survival


def _power(p: float, working: int) -> float:
    """Return (1-p)^working; 1-p rounded first would be off by the sum of its errors."""
    return math.exp(working * math.log1p(-p))


@lru_cache(maxsize=65_536)
def group_failures(
    units: tuple[tuple[int, float], ...], room: int
) -> tuple[tuple[float, ...], float]:
    """Return how many of unequal units fail, up to `room` - 1, and the chance of `room` or more.

    `units` gives how many there are of each failure probability.
    """
    if room <= 0:
        return (), 1.0
    counts, reached = [1.0], 0.0
    for number, p in units:
        own = failure_counts(number, p, room - 1)
        tails = (1.0, *failure_tails(number, p, room))
        grown = [0.0] * min(room, len(counts) + len(own) - 1)
        for before, share in enumerate(counts):
            if room - before < len(tails):
                reached += share * tails[room - before]
            for failed, one in enumerate(own[: room - before]):
                grown[before + failed] += share * one
        counts = grown
    return tuple(counts), reached
