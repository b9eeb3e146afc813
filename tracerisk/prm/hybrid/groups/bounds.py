"""How likely one of many groups fails, from what is known of each: certified from both sides.

With F_g the probability that group g fails on a path, x = sum F_g and y = sum F_g^2, one of them
fails with U = 1 - E prod (1 - F_g) (own derivation):

- U <= E x, and for E x <= 2/3  U <= 1 - phi(E x) + E y / 2,  phi(x) = 1 - x + x^2/2 - x^3/6:
  prod (1 - F_g) >= 1 - x + (x^2 - y)/2 - x^3/6 by Bonferroni, which lies above the tangent of phi
  at E x less y/2 wherever that tangent is above zero.
- U >= E x - sum_{g<h} E F_g F_h, by Bonferroni, and E F_g F_h <= (E F_g^2 E F_h^2)^(1/2).
- U >= m (1 - exp(-r)) / r, m = E x, r = v / m with v >= E x^2: prod (1 - F_g) <= exp(-x), and no
  x with these moments has a greater E exp(-x) than one that is 0 or v / m.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

_TANGENT = 2.0 / 3.0
"""Up to which E x the tangent of phi is a bound."""


class Moments(NamedTuple):
    """What is known of the failure probability F of one group over the paths of a mission."""

    least: float
    """Lower bound of the mean of F, in [0, 1]."""
    most: float
    """Upper bound of the mean of F, in [0, 1]."""
    square: float
    """Upper bound of the mean of F squared, in [0, 1]."""


class Range(NamedTuple):
    """Bounds of a probability."""

    least: float
    """Lower bound, in [0, 1]."""
    most: float
    """Upper bound, in [0, 1]."""


def any_group(groups: Sequence[Moments], *, is_certain: bool) -> Range:
    """Return the probability that a group fails; on a certain path they fail independently."""
    if len(groups) == 1:
        return Range(groups[0].least, groups[0].most)
    if is_certain:
        return any_block([Range(group.least, group.most) for group in groups])
    return Range(_least(groups), _most(groups))


def any_block(blocks: Sequence[Range]) -> Range:
    """Return the probability that one of independent blocks fails."""
    return Range(
        _any([block.least for block in blocks]),
        _any([block.most for block in blocks]),
    )


def _any(independent: Sequence[float]) -> float:
    if max(independent, default=0.0) >= 1.0:
        return 1.0
    return 0.0 - math.expm1(math.fsum(math.log1p(-p) for p in independent))


def _most(groups: Sequence[Moments]) -> float:
    mean = math.fsum(group.most for group in groups)
    if mean > _TANGENT:
        return min(1.0, mean)
    square = math.fsum(group.square for group in groups)
    return min(mean, mean - mean * mean / 2.0 + mean**3 / 6.0 + square / 2.0)


def _least(groups: Sequence[Moments]) -> float:
    mean = math.fsum(group.least for group in groups)
    squares = math.fsum(group.square for group in groups)
    second = math.fsum(math.sqrt(group.square) for group in groups) ** 2
    candidates = [group.least for group in groups]
    candidates.append(mean - max(0.0, second - squares) / 2.0)
    if second > 0.0 and mean > 0.0:
        ratio = second / mean
        candidates.append(0.0 - mean * math.expm1(-ratio) / ratio)
    return max(candidates)
