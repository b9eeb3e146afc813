"""Unlike units of which some wait as spares, over one visit.

Units serve in the order of the description: the first that have not failed work, the others
wait, and the next of them takes over (docs/theory.md#groups). With like units this is the chain
of standby systems in M. Rausand, A. Hoyland, "System Reliability Theory", 2nd ed. (2004).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from decimal import Decimal

from tracerisk.adder.quantify.outcome import ONE, SURELY, ZERO, Outcome
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.strong_components import reached
from tracerisk.errors import HardwareError

MOST_STATES = 5_000
"""The most sets of failed units: 12 units, one of which must work, have 4,095."""
_NEGLIGIBLE = Decimal("1e-35")
_FAILED = -1

_Chain = list[list[tuple[int, Decimal]]]
"""For each state the ways out of it, each with its rate; `_FAILED` is the failed group."""


def unlike_spares(hazards: Sequence[Decimal], redundancy: Redundancy) -> Outcome:
    """Return the outcome of one visit for units with these hazards while they work.

    An infinite hazard is a unit that fails as soon as it works, or waits and is not cold.
    Raises HardwareError where there are too many units to distinguish.
    """
    states = _States(hazards, redundancy)
    start = states.settled(0)
    chain: _Chain = []
    for number in states:
        chain.append(states.ways(number))
    return _failed_by_the_end(chain, start)


def like_spares(hazard: Decimal, quantity: int, redundancy: Redundancy) -> Outcome:
    """Return the outcome of one visit for so many units of the same hazard while they work."""
    if hazard.is_infinite():
        return SURELY
    working = redundancy.required * hazard
    spares = quantity - redundancy.required
    dormancy, switch = Decimal(redundancy.dormancy), Decimal(redundancy.switch)
    chain: _Chain = [
        [
            (lost + 1, working * (ONE - switch) + (spares - lost) * dormancy * hazard),
            (_FAILED, working * switch),
        ]
        for lost in range(spares)
    ]
    chain.append([(_FAILED, working)])
    return _failed_by_the_end(chain, [(0, ONE)])


class _States:
    """The sets of failed units that a group of spares meets, as bits, numbered as they come."""

    def __init__(self, hazards: Sequence[Decimal], redundancy: Redundancy) -> None:
        self._hazards = hazards
        self._redundancy = redundancy
        self._dormancy = Decimal(redundancy.dormancy)
        self._switch = Decimal(redundancy.switch)
        self._numbers: dict[int, int] = {}
        self._sets: list[int] = []

    def __iter__(self) -> Iterator[int]:
        number = 0
        while number < len(self._sets):
            yield number
            number += 1

    def settled(self, failed: int) -> list[tuple[int, Decimal]]:
        """Return the states that a set of failed units becomes at once, with their chances."""
        for target, rate, chance in self._steps(failed):
            if rate.is_infinite():
                at_once = [] if target is None else self.settled(target)
                pairs = [(state, chance * share) for state, share in at_once]
                lost = ONE - chance if target is not None else ONE
                return [*pairs, (_FAILED, lost)] if lost else pairs
        if failed not in self._numbers:
            if len(self._sets) >= MOST_STATES:
                raise HardwareError(
                    f"{len(self._hazards)} spares that differ are too many to follow; allowed: "
                    f"{MOST_STATES} sets of failed units, as 12 units have; describe the group as "
                    "several components"
                )
            self._numbers[failed] = len(self._sets)
            self._sets.append(failed)
        return [(self._numbers[failed], ONE)]

    def ways(self, number: int) -> list[tuple[int, Decimal]]:
        """Return the ways out of a state."""
        pairs = []
        for target, rate, chance in self._steps(self._sets[number]):
            if rate == ZERO:
                continue
            if target is None:
                pairs.append((_FAILED, rate))
                continue
            if chance < ONE:
                pairs.append((_FAILED, rate * (ONE - chance)))
            if chance > ZERO:
                pairs += [(state, rate * chance * share) for state, share in self.settled(target)]
        return pairs

    def _steps(self, failed: int) -> Iterator[tuple[int | None, Decimal, Decimal]]:
        """Yield what each unit's failure leads to, its rate, and the chance that it is survived."""
        sound = [unit for unit in range(len(self._hazards)) if not failed >> unit & 1]
        required = self._redundancy.required
        for place, unit in enumerate(sound):
            hazard = self._hazards[unit]
            if place < required:
                has_spare = len(sound) > required
                yield failed | 1 << unit if has_spare else None, hazard, ONE - self._switch
            elif self._dormancy > ZERO:
                yield failed | 1 << unit, self._dormancy * hazard, ONE


def _failed_by_the_end(chain: _Chain, start: Sequence[tuple[int, Decimal]]) -> Outcome:
    """Return the outcome of a chain over a time of one.

    By uniformisation: A. Jensen, "Markoff chains as an aid in the study of Markoff processes",
    Skandinavisk Aktuarietidskrift 36 (1953). All terms are positive.
    """
    leaving = [sum((rate for _, rate in ways), ZERO) for ways in chain]
    now = [ZERO] * len(chain)
    lost = ZERO
    for state, share in start:
        if state == _FAILED:
            lost += share
        else:
            now[state] += share
    fastest = max(leaving, default=ZERO)
    if fastest == ZERO or not any(now) or not _can_fail(chain, now):
        return Outcome(lost, sum(now, ZERO))
    weight = (-fastest).exp()
    p, q = weight * lost, weight * sum(now, ZERO)
    step = 0
    while True:
        following = [
            share * (fastest - rate) / fastest for share, rate in zip(now, leaving, strict=True)
        ]
        for state, ways in enumerate(chain):
            if now[state] == ZERO:
                continue
            for target, rate in ways:
                if target == _FAILED:
                    lost += now[state] * rate / fastest
                else:
                    following[target] += now[state] * rate / fastest
        now = following
        step += 1
        weight *= fastest / step
        p += weight * lost
        q += weight * sum(now, ZERO)
        if step > fastest:
            # What follows is less than a geometric series.
            rest = weight * fastest / (step + 1 - fastest)
            if rest * (lost + sum(now, ZERO)) <= _NEGLIGIBLE * min(p, q):
                return Outcome(p, q)


def _can_fail(chain: _Chain, now: Sequence[Decimal]) -> bool:
    """Return whether the group can fail at all: some units never do."""
    begun = [state for state, share in enumerate(now) if share]
    met = reached(begun, lambda state: [to for to, rate in chain[state] if rate and to != _FAILED])
    return any(rate and to == _FAILED for state in met for to, rate in chain[state])
