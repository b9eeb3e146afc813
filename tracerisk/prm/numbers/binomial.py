"""How many of equal independent units fail: probabilities and tails without a subtraction."""

from __future__ import annotations

import math
from functools import lru_cache

from tracerisk.prm.numbers.probability import PairedFloat, log_complement

_EXACT_POWER = 16
_EXACT_CHOICE = 1_000
_FEW = 16


def failure_counts(units: int, p: float, most: int) -> tuple[float, ...]:
    """Return the probabilities that 0, 1, ... up to `most` of the units fail."""
    return _counts(units, p, _complement(p), most)


def failure_tails(units: int, p: float, most: int) -> tuple[float, ...]:
    """Return the probabilities that at least 1, 2, ... up to `most` of the units fail."""
    return _tails(units, p, _complement(p), most)


def _complement(p: float) -> float:
    return p.q if isinstance(p, PairedFloat) else 1.0 - p


@lru_cache(maxsize=65_536)
def _counts(units: int, p: float, q: float, most: int) -> tuple[float, ...]:
    return tuple(_count(units, p, q, failed) for failed in range(min(units, most) + 1))


@lru_cache(maxsize=65_536)
def _tails(units: int, p: float, q: float, most: int) -> tuple[float, ...]:
    most = min(units, most)
    if most < 1:
        return ()
    tails = [_tail(units, p, q, most)]
    for failed in range(most - 1, 0, -1):
        tails.append(tails[-1] + _count(units, p, q, failed))
    return tuple(reversed(tails))


def _tail(units: int, p: float, q: float, least: int) -> float:
    total = 0.0
    for failed in range(least, units + 1):
        term = _count(units, p, q, failed)
        total += term
        # Past the mean the terms fall faster and faster.
        if failed > units * abs(p) and abs(term) < 1e-20 * abs(total):
            break
    return total


def _count(units: int, p: float, q: float, failed: int) -> float:
    working = units - failed
    if p == 0.0 or q == 0.0:
        return 1.0 if failed == units * p else 0.0
    if isinstance(p, complex):
        return math.comb(units, failed) * p**failed * q**working
    if units > _EXACT_CHOICE:
        choices = math.lgamma(units + 1) - math.lgamma(failed + 1) - math.lgamma(working + 1)
        return math.exp(choices + failed * math.log(p) + working * log_complement((p, q)))
    survival = q**working if working <= _EXACT_POWER else math.exp(working * log_complement((p, q)))
    choices = math.comb(units, failed) if failed <= _FEW else _choices(units)[failed]
    return choices * p**failed * survival


@lru_cache(maxsize=2 * _EXACT_CHOICE)
def _choices(units: int) -> tuple[int, ...]:
    """Return in how many ways 0, 1, ... all of the units can be chosen.

    Each from the one before: for hundreds of units that is much faster than computing each by
    itself.
    """
    choices = [1]
    for chosen in range(units):
        choices.append(choices[-1] * (units - chosen) // (chosen + 1))
    return tuple(choices)


def group_failures(
    units: tuple[tuple[int, float], ...], room: int
) -> tuple[tuple[float, ...], float]:
    """Return how many of unequal units fail, up to `room` - 1, and the chance of `room` or more.

    `units` gives how many there are of each failure probability.
    """
    return _group(tuple((number, p, _complement(p)) for number, p in units), room)


@lru_cache(maxsize=65_536)
def _group(
    units: tuple[tuple[int, float, float], ...], room: int
) -> tuple[tuple[float, ...], float]:
    if room <= 0:
        return (), 1.0
    counts, reached = [1.0], 0.0
    for number, p, q in units:
        own = _counts(number, p, q, room - 1)
        tails = (1.0, *_tails(number, p, q, room))
        grown = [0.0] * min(room, len(counts) + len(own) - 1)
        for before, share in enumerate(counts):
            if room - before < len(tails):
                reached += share * tails[room - before]
            for failed, one in enumerate(own[: room - before]):
                grown[before + failed] += share * one
        counts = grown
    return tuple(counts), reached
