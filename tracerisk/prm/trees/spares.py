"""A group of like units of which some wait as spares, as a small Markov chain.

Source: the models of standby systems of M. Rausand, A. Hoyland, "System Reliability Theory",
2nd ed. (2004). Groups of unlike units, and spares that several groups share, are in
`tracerisk.prm.other_models.dynamic`.
Time is the hazard of a working unit, -log(1-p) of a visit in which it fails with p. So two visits
one after the other are one of their summed hazard: where a function is cut makes no difference.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import mul
from typing import TYPE_CHECKING, NamedTuple, cast

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.arrays import np
from tracerisk.prm.numbers.probability import Probability, log_complement, pair_of, total

if TYPE_CHECKING:
    from tracerisk.prm.numbers.distributions import Samples

_NEGLIGIBLE = 1e-18
"""What is left of a series when it ends, relative to each of its sums."""
_SMALLEST = 1e-290
"""What is smaller need not keep its digits."""


@dataclass(frozen=True, slots=True)
class Spares:
    """How the units of a group that are not required wait.

    Raises ModelError when one of them is outside [0, 1].
    """

    dormancy: float = 1.0
    """Failure rate of a waiting unit divided by the rate of a working one, in [0, 1]."""
    switch: float = 0.0
    """Probability that the take-over by a spare fails, which fails the group, in [0, 1]."""

    def __post_init__(self) -> None:
        for name in ("dormancy", "switch"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ModelError(f"spares: {name} {value!r} is outside [0, 1]; give one within")


class Outcome(NamedTuple):
    """What comes of a group in a visit."""

    survived: tuple[float, ...]
    """Probability of survival with 0, 1, 2... more failed units, (n_spares + 1,)."""
    failed: float
    """Probability that the group fails."""

    @property
    def pair(self) -> Probability:
        """The probability that the group fails."""
        return Probability(self.failed, total(self.survived))


class SpareGroup(NamedTuple):
    """A group of like units of which some work while the others wait.

    With m failed units, m up to s = units - required, and k required, one more fails at the rate
    k (1 - switch) + (s - m) dormancy, the group at k switch; with m = s the group fails at k.
    """

    units: int
    """Number of all units."""
    required: int
    """Number of units that must work, 1 to `units`."""
    spares: Spares
    """How the others wait and take over."""

    def rates(self, lost: int) -> tuple[float, float]:
        """Return the rates of one more failed unit, and of the group's failure, by the hazard."""
        waiting = self.units - self.required - lost
        if waiting == 0:
            return 0.0, float(self.required)
        more = self.required * (1.0 - self.spares.switch) + waiting * self.spares.dormancy
        return more, self.required * self.spares.switch

    def visit(self, unit: Probability, lost: int) -> Outcome:
        """Return what comes of a visit in which a working unit fails with `unit`.

        Relative error of each number below 1e-12, for rare ones too.
        """
        count = self.units - self.required - lost + 1
        rates = [self.rates(lost + more) for more in range(count)]
        return _outcome(unit, self.required, self.spares.dormancy, tuple(rates))

    def difference(self, unit: Probability, lost: int) -> Outcome:
        """Return how one more failed unit's cost before a visit follows from its cost after it.

        Let w(m) be the success that follows a visit left with m failed units, 0 for m > s, and
        u(m) that of a visit begun so: u' = -(a(m) + b(m)) u(m) + a(m) u(m+1) by the hazard, a and
        b being `rates`. Then d(m) = u(m) - u(m+1) obeys d'(m) = -(k + (s-m) dormancy) d(m) +
        (k (1 - switch) + (s-m-1) dormancy) d(m+1), with d = w(m) - w(m+1) after the visit: a chain
        of the same kind, without a negative term (own derivation). `survived` are its
        probabilities, `failed` is what they leave of one.
        """
        spares, required = self.spares, self.required
        last = self.units - required - lost
        rates = [
            (
                required * (1.0 - spares.switch) + (last - more - 1) * spares.dormancy,
                required * spares.switch + spares.dormancy,
            )
            for more in range(last)
        ]
        return _outcome(unit, required, spares.dormancy, (*rates, (0.0, float(required))))

    def visits(self, unit: Samples, lost: int) -> tuple[list[Samples], Samples]:
        """Return `visit` for many probabilities at once, (n,): survived by count, and failed."""
        count = self.units - self.required - lost + 1
        rates = tuple(self.rates(lost + more) for more in range(count))
        with np.errstate(divide="ignore"):
            hazards = -np.log1p(-unit)
        sure = np.isinf(hazards)
        fastest = self.required + (count - 1) * self.spares.dormancy
        mean = np.where(sure, 0.0, hazards) * fastest
        survived = [np.zeros(len(mean)) for _ in range(count)]
        failed = np.zeros(len(mean))
        # By the logarithm: for a large mean the first weight exp(-mean) underflows to zero, from
        # which no product recovers the others.
        log_mean = np.log(np.maximum(mean, 1e-300))
        steps = _steps(rates, fastest, self.spares.dormancy)
        greatest = float(mean.max(initial=0.0))
        for number, (left, gone) in enumerate(steps):
            weight = np.exp(number * log_mean - mean - math.lgamma(number + 1))
            for place, share in enumerate(left):
                if share:
                    survived[place] += weight * share
            failed += weight * gone
            if number > greatest + count and (
                number >= greatest + 10.0 * math.sqrt(greatest) + 20.0 + 2 * count
            ):
                break
        return [np.where(sure, 0.0, array) for array in survived], np.where(sure, 1.0, failed)


def spare_group_failure(p: float, *, units: int, required: int, spares: Spares) -> Probability:
    """Return the probability that fewer than `required` of `units` serve during one visit.

    `p` is the failure probability of a working unit over the visit; see `SpareGroup`.
    Relative error of both halves below 1e-12, for rare failures too.
    Raises ValueError for figures outside their ranges.
    """
    if not 1 <= required <= units or not 0.0 <= p <= 1.0:
        raise ValueError("required from 1 to units, and a probability from 0 to 1")
    return SpareGroup(units, required, spares).visit(pair_of(p), 0).pair


def _outcome(
    unit: Probability, required: int, dormancy: float, rates: tuple[tuple[float, float], ...]
) -> Outcome:
    if isinstance(unit.p, complex):
        return _tilted(unit, required, dormancy, rates)
    if unit.q == 0.0:
        # A unit that fails at once takes every spare with it.
        return Outcome((0.0,) * len(rates), 1.0)
    return _after(-log_complement(unit), required, dormancy, rates)


def _tilted(
    unit: Probability, required: int, dormancy: float, rates: tuple[tuple[float, float], ...]
) -> Outcome:
    """Return the outcome for numbers with a derivative as imaginary part: see `pair_importance`."""
    here = _outcome(Probability(unit.p.real, unit.q.real), required, dormancy, rates)
    if unit.q.real == 0.0:
        return here
    step = unit.p.imag / unit.q.real
    tilted = []
    entering = 0.0
    for place, (share, (more, _)) in enumerate(zip(here.survived, rates, strict=True)):
        leaving = (required + (len(rates) - 1 - place) * dormancy) * share
        tilted.append(complex(share, step * (entering - leaving)))
        entering = more * share
    fails = total(share * end for share, (_, end) in zip(here.survived, rates, strict=True))
    return Outcome(
        tuple(cast(float, item) for item in tilted), cast(float, complex(here.failed, step * fails))
    )


@lru_cache(maxsize=65_536)
def _after(
    hazard: float, required: int, dormancy: float, rates: tuple[tuple[float, float], ...]
) -> Outcome:
    """Return where the chain is after so much hazard, by uniformisation (A. Jensen, 1953).

    All terms are positive; weights are taken from the greatest outwards and summed.
    """
    fastest = required + (len(rates) - 1) * dormancy
    mean = fastest * hazard
    peak = int(mean)
    weights = [1.0] * (peak + 1)
    for count in range(peak, 0, -1):
        weights[count - 1] = weights[count] * count / mean
    survived = [0.0] * len(rates)
    failed = whole = 0.0
    weight = 1.0
    for number, (left, gone) in enumerate(_steps(rates, fastest, dormancy)):
        weight = weights[number] if number <= peak else weight * mean / number
        survived = [sofar + weight * share for sofar, share in zip(survived, left, strict=True)]
        failed += weight * gone
        whole += weight
        if number >= peak and weight == 0.0:
            break
        if number >= max(peak, len(rates)):
            # What follows is less than a geometric series of these ratios.
            rest = weight * mean / (number + 1 - mean)
            smallest = _SMALLEST * whole
            least = min((x for x in (*survived, failed) if x > smallest), default=0.0)
            if rest <= _NEGLIGIBLE * least:
                break
    return Outcome(tuple(share / whole for share in survived), failed / whole)


def _steps(
    rates: Sequence[tuple[float, float]], fastest: float, dormancy: float
) -> Iterator[tuple[list[float], float]]:
    """Yield where the chain is after 0, 1, 2... steps of the fastest rate: left by place, gone."""
    now, gone = [1.0] + [0.0] * (len(rates) - 1), 0.0
    mores, ends = [more for more, _ in rates], [end for _, end in rates]
    while True:
        yield now, gone
        gone += sum(map(mul, now, ends)) / fastest
        entering = [0.0, *map(mul, now, mores)]
        # A place is left the more slowly the fewer units wait: nothing is subtracted.
        now = [
            (entering[place] + share * place * dormancy) / fastest
            for place, share in enumerate(now)
        ]
