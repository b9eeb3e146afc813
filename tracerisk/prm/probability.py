"""Probabilities as pairs (p, 1-p), and the algebra of gates over independent inputs.

Both halves of a pair are always sums and products of non-negative numbers, so both keep
their relative precision: a failure of 1e-20 and the survival beside it are exact to a few
units in the last place.
Nowhere is 1-x taken of an x that was computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from tracerisk.errors import ModelError


class Probability(NamedTuple):
    """The probability `p` of an event, and `q` of its complement, each to full precision."""

    p: float
    q: float

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


def at_least(k: int, inputs: Sequence[Probability]) -> Probability:
    """Return the probability that at least `k` of the independent inputs happen.

    `k = 1` is OR, `k = len(inputs)` is AND; of no inputs at all, one never happens.
    """
    if k <= 0:
        return Probability(1.0, 0.0)
    if k == 1:
        p, q = 0.0, 1.0
        for pair in inputs:
            p, q = p + q * pair.p, q * pair.q
        return Probability(p, q)
    dual = len(inputs) - k + 1
    if dual < k:
        # "At least k happen" is the complement of "at least n-k+1 do not": the shorter count.
        return at_least(dual, [pair.complement for pair in inputs]).complement
    counts = [1.0]
    reached = 0.0
    for pair in inputs:
        if len(counts) == k:
            reached += counts[-1] * pair.p
        counts = _convolve(counts, pair, k)
    return Probability(reached, sum(counts))


def counted(least: int, most: int, inputs: Sequence[Probability]) -> Probability:
    """Return the probability that from `least` to `most` of the independent inputs happen."""
    counts = [1.0]
    for pair in inputs:
        counts = _convolve(counts, pair, len(inputs) + 1)
    return Probability(sum(counts[least : most + 1]), sum(counts[:least]) + sum(counts[most + 1 :]))


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
        sum(
            share * tail[k - 1 - count]
            for count, share in enumerate(head)
            if k - 1 - count < len(tail)
        )
        for head, tail in zip(heads, reversed(tails), strict=True)
    )


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
