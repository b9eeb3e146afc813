"""Probabilities as pairs (p, 1-p), and the algebra of gates over independent inputs.

Both halves of a pair are always sums and products of non-negative numbers, so both keep
their relative precision: a failure of 1e-20 and the survival beside it are exact to a few
units in the last place.
Nowhere is 1-x taken of an x that was computed.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Sequence
from itertools import accumulate
from operator import mul

from tracerisk.errors import ModelError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import NamedTuple

    class _Pair(NamedTuple):
        p: float
        """Probability of the event, in [0, 1]."""
        q: float
        """Probability of the complement, in [0, 1], not rounded through 1 - p."""

else:
    _Pair = namedtuple("_Pair", ("p", "q"))

MANY = 64
"""From so many inputs on, products of complements are taken by logarithms."""


class Probability(_Pair):
    """The probability `p` of an event, and `q` of its complement, each to full precision."""

    __slots__ = ()

    @classmethod
    def of(cls, p: float) -> Probability:
        """Return the pair of a given number.

        The one subtraction that is allowed: `p` is an input, so 1-p is correctly rounded.
        Raises ModelError when `p` is not in [0, 1].
        """
        if not 0.0 <= p <= 1.0:
            raise ModelError(f"probability {p!r} is outside [0, 1]; give a number within")
        return cls(float(p), 1.0 - p)

    @property
    def complement(self) -> Probability:
        """The pair of the complementary event."""
        return Probability(self.q, self.p)


class PairedFloat(float):
    """The `p` of a pair as a number that keeps its `q`, where 1-p would be rounded otherwise.

    A unit that fails almost surely survives with a probability that only the pair holds.
    """

    __slots__ = ("q",)
    q: float

    def __new__(cls, pair: Probability) -> PairedFloat:
        """Make the number of a pair."""
        made = super().__new__(cls, pair.p)
        made.q = pair.q
        return made

    def __getnewargs__(self) -> tuple[Probability]:  # type: ignore[override]
        """Return what a copy is made of."""
        return (Probability(float(self), self.q),)


def value_of(pair: Probability) -> float:
    """Return a pair as one number, from which `pair_of` makes the same pair again."""
    return pair.p if pair.q == 1.0 - pair.p else PairedFloat(pair)


def pair_of(value: float) -> Probability:
    """Return the pair of a given number, or of one made by `value_of`.

    Raises ModelError when it is not in [0, 1].
    """
    if isinstance(value, PairedFloat):
        return Probability(float(value), value.q)
    return Probability.of(value)


def total(values: Iterable[float]) -> float:
    """Return the sum, correctly rounded.

    Numbers with a derivative as imaginary part (see `pair_importance`) are summed as they come.
    """
    listed = list(values)
    try:
        return math.fsum(listed)
    except TypeError:
        return sum(listed)


def at_least(k: int, inputs: Sequence[Probability]) -> Probability:
    """Return the probability that at least `k` of the independent inputs happen.

    `k = 1` is OR, `k = len(inputs)` is AND; of no inputs at all, one never happens.
    """
    if k <= 0:
        return Probability(1.0, 0.0)
    if k == 1:
        return any_of(inputs)
    dual = len(inputs) - k + 1
    if dual < k:
        # "At least k happen" is the complement of "at least n-k+1 do not": the shorter count.
        if dual == 2:
            q, p = _two_of([(q, p) for p, q in inputs])
            return Probability(p, q)
        return at_least(dual, [pair.complement for pair in inputs]).complement
    if k == 2:
        return Probability(*_two_of(inputs))
    counts = [1.0]
    reached = 0.0
    for pair in inputs:
        if len(counts) == k:
            reached += counts[-1] * pair.p
        counts = _convolve(counts, pair, k)
    return Probability(reached, total(counts))


def _two_of(inputs: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the pair of "at least two": the commonest vote, counted without lists."""
    none, one, more = 1.0, 0.0, 0.0
    for p, q in inputs:
        more += one * p
        one = one * q + none * p
        none *= q
    return more, none + one


def any_of(inputs: Sequence[tuple[float, float]]) -> Probability:
    """Return the probability that any of the independent inputs happens, pairs (p, 1-p).

    The rounding of many factors adds up, so that the complements of many are multiplied as a
    sum of their logarithms, which itself is rounded once.
    """
    if len(inputs) < MANY or not _are_numbers(inputs):
        p, q = 0.0, 1.0
        for p_input, q_input in inputs:
            p, q = p + q * p_input, q * q_input
        return Probability(p, q)
    logarithm = math.fsum(log_complement(pair) for pair in inputs)
    return Probability(-math.expm1(logarithm), math.exp(logarithm))


def _are_numbers(inputs: Sequence[tuple[float, float]]) -> bool:
    """Whether the pairs are plain numbers, not samples nor numbers with a derivative."""
    return all(isinstance(p, float) for p, _ in inputs)


def log_complement(pair: tuple[float, float]) -> float:
    """Return log(1-p) from the more precise half of the pair."""
    p, q = pair
    if p < 0.5:
        return math.log1p(-p)
    return math.log(q) if q else -math.inf


def counted(least: int, most: int, inputs: Sequence[Probability]) -> Probability:
    """Return the probability that from `least` to `most` of the independent inputs happen."""
    counts = [1.0]
    for pair in inputs:
        counts = _convolve(counts, pair, len(inputs) + 1)
    return Probability(total(counts[least : most + 1]), total(counts[:least] + counts[most + 1 :]))


def deciding(
    k: int, before: Sequence[Probability], after: Sequence[Probability]
) -> tuple[float, ...]:
    """Return for each input i the probability that it alone decides a gate "at least `k`".

    Input i decides when exactly `k - 1` of the others happen; those that stand before it take
    their probability from `before`, those that stand after it from `after`.
    With `before` equal to `after` these are the gate's partial derivatives; with two different
    assignments, sum_i deciding_i (before_i - after_i) is the exact difference of the gate's
    probability between them (a telescoping sum, own derivation).
    """
    if not before:
        return ()
    if k == 1:
        return _only(before, after)
    dual = len(before) - k + 1
    if dual < k:
        return deciding(
            dual, [pair.complement for pair in before], [pair.complement for pair in after]
        )
    heads = [[1.0]]
    for pair in before[:-1]:
        heads.append(_convolve(heads[-1], pair, k))
    tails = [[1.0]]
    for pair in after[:0:-1]:
        tails.append(_convolve(tails[-1], pair, k))
    return tuple(
        total(
            share * tail[k - 1 - count]
            for count, share in enumerate(head)
            if k - 1 - count < len(tail)
        )
        for head, tail in zip(heads, reversed(tails), strict=True)
    )


def _only(before: Sequence[Probability], after: Sequence[Probability]) -> tuple[float, ...]:
    """Return for each input the probability that none of the others happens; see `deciding`."""
    if len(before) < MANY or not (_are_numbers(before) and _are_numbers(after)):
        heads = accumulate((pair.q for pair in before[:-1]), mul, initial=1.0)
        tails = list(accumulate((pair.q for pair in after[:0:-1]), mul, initial=1.0))
        return tuple(map(mul, heads, reversed(tails)))
    log_heads = log_products(before[:-1])
    log_tails = log_products(after[:0:-1])
    return tuple(
        math.exp(head + tail) for head, tail in zip(log_heads, reversed(log_tails), strict=True)
    )


def log_products(pairs: Sequence[Probability]) -> list[float]:
    """Return the logarithms of the running products of complements, that of none first.

    The rounding of each sum is carried on to the next (Kahan 1965).
    """
    sums = [0.0]
    total, lost = 0.0, 0.0
    for pair in pairs:
        term = log_complement(pair)
        if term == -math.inf:
            sums.extend([-math.inf] * (len(pairs) + 1 - len(sums)))
            break
        term -= lost
        grown = total + term
        lost = (grown - total) - term
        total = grown
        sums.append(total)
    return sums


def mean_of(parts: Iterable[tuple[float, Probability]]) -> Probability:
    """Return the mean of pairs, each with its share."""
    listed = list(parts)
    return Probability(
        math.fsum(share * pair.p for share, pair in listed),
        math.fsum(share * pair.q for share, pair in listed),
    )


def worth(above: float, below: float) -> float:
    """Return the ratio of two figures that are never negative; 1 where both are 0."""
    if below > 0.0:
        return above / below
    return math.inf if above > 0.0 else 1.0


def _convolve(counts: list[float], pair: Probability, limit: int) -> list[float]:
    """Add one input to the distribution of how many happen, keeping counts below `limit`."""
    if limit == 1:
        return [counts[0] * pair.q]
    grown = [0.0] * min(len(counts) + 1, limit)
    for count, share in enumerate(counts):
        grown[count] += share * pair.q
        if count + 1 < limit:
            grown[count + 1] += share * pair.p
    return grown
