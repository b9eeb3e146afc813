"""Redundant groups whose failed units are repaired while missions go on.

Own derivation: docs/theory.md#repaired-groups. The group is a Markov chain from mission to
mission, over the units that have failed; it is whole again after a mission that it failed.
Nothing is subtracted: matrices by uniformisation (A. Jensen, 1953), the mean number of missions
by the elimination of W. Grassmann, M. Taksar, D. Heyman, Operations Research 33 (1985).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Protocol

from tracerisk.adder.quantify.outcome import NEVER, ONE, ZERO, Outcome, after
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import HardwareError

MOST_STATES = 63
"""The most states that are followed: 6 units that differ have 63 sets in which one works."""
_SURE = Decimal(100)
"""The hazard of a unit that surely fails: it survives once in 1e43."""
_SHORT = Decimal(4)
"""The most events of a time whose matrix is summed up; longer ones are squares of it."""
_NEGLIGIBLE = Decimal("1e-42")

_Row = list[Decimal]


@dataclass(frozen=True, slots=True)
class Renewal:
    """When the failed units of a group whose failures stay hidden are replaced."""

    missions: float = 1.0
    """The number of missions between two tests, at which all of them are."""
    repair: float | None = None
    """The time of a mission over the mean time of a repair; `None`: replaced by the tests."""
    in_mission: bool = False
    """Whether repair begins and ends within missions, rather than between them."""


EACH_MISSION = Renewal()
"""All are replaced before each mission."""


class _Units(Protocol):
    """The units of a group; a state is what has failed of them, 0 if nothing has."""

    def failing(self, state: int) -> Iterator[tuple[int | None, Decimal]]:
        """Yield the state after each failure, `None` for the group's, with its rate."""

    def repairing(self, state: int) -> Iterator[tuple[int, int]]:
        """Yield the state after one repair, and how many units lead to it."""

    def mended(self, before: int, now: int, repaired: Outcome) -> Iterator[tuple[int, Decimal]]:
        """Yield the states after the repair of those failed `before`, each by chance."""


@dataclass(frozen=True, slots=True)
class _Like:
    """Like units: the state is the number of those that have failed."""

    hazard: Decimal
    """The hazard of a unit at work over a mission [1]."""
    quantity: int
    """The number of units."""
    redundancy: Redundancy
    """How many of them must work."""

    def failing(self, state: int) -> Iterator[tuple[int | None, Decimal]]:
        waiting = self.quantity - self.redundancy.required - state
        working = self.redundancy.required * self.hazard
        switch = Decimal(self.redundancy.switch)
        if waiting == 0:
            yield None, working
            return
        dormant = waiting * Decimal(self.redundancy.dormancy) * self.hazard
        yield state + 1, working * (ONE - switch) + dormant
        if switch:
            yield None, working * switch

    def repairing(self, state: int) -> Iterator[tuple[int, int]]:
        if state:
            yield state - 1, state

    def mended(self, before: int, now: int, repaired: Outcome) -> Iterator[tuple[int, Decimal]]:
        for count in range(before + 1):
            ways = math.comb(before, count)
            yield now - count, ways * repaired.p**count * repaired.q ** (before - count)


@dataclass(frozen=True, slots=True)
class _Unlike:
    """Units that differ, in the order in which they serve; the state holds a bit for each."""

    hazards: tuple[Decimal, ...]
    """The hazard of each unit at work over a mission [1], (quantity,)."""
    redundancy: Redundancy
    """How many of them must work."""

    def failing(self, state: int) -> Iterator[tuple[int | None, Decimal]]:
        required, switch = self.redundancy.required, Decimal(self.redundancy.switch)
        sound = [unit for unit in range(len(self.hazards)) if not state >> unit & 1]
        for place, unit in enumerate(sound):
            hazard, following = self.hazards[unit], state | 1 << unit
            if place >= required:
                yield following, hazard * Decimal(self.redundancy.dormancy)
            elif len(sound) == required:
                yield None, hazard
            else:
                yield following, hazard * (ONE - switch)
                yield None, hazard * switch

    def repairing(self, state: int) -> Iterator[tuple[int, int]]:
        for unit in range(len(self.hazards)):
            if state >> unit & 1:
                yield state ^ 1 << unit, 1

    def mended(self, before: int, now: int, repaired: Outcome) -> Iterator[tuple[int, Decimal]]:
        ways = [(now, ONE)]
        for unit in range(len(self.hazards)):
            if before >> unit & 1:
                ways = [
                    (state ^ bit << unit, chance * share)
                    for state, chance in ways
                    for bit, share in ((1, repaired.p), (0, repaired.q))
                ]
        yield from ways


def repaired_group(
    own: Sequence[Outcome], redundancy: Redundancy, repair: float, *, in_mission: bool
) -> Outcome:
    """Return in which share of all missions a group fails by its units' own failures.

    `own` are the outcomes of the units at work all the time of one mission, `repair` the time of
    a mission over the mean time of a repair. Missions follow one another without a pause. Units
    that fail in one are missing in the next at least, unless repair goes on `in_mission`.
    Raises HardwareError where there are too many units to follow.
    """
    hazards = tuple(min(unit.hazard, _SURE) for unit in own)
    is_alike = len(set(hazards)) == 1
    units: _Units = (
        _Like(hazards[0], len(hazards), redundancy) if is_alike else _Unlike(hazards, redundancy)
    )
    states = _states(units, len(hazards))
    numbers = {state: number for number, state in enumerate(states)}
    repairs = Decimal(repair)
    rates = [[ZERO] * len(states) for _ in states]
    failing = [ZERO] * len(states)
    for number, state in enumerate(states):
        for target, rate in units.failing(state):
            if target is None:
                failing[number] += rate
            elif rate:
                rates[number][numbers[target]] += rate
        for target, count in units.repairing(state) if in_mission else ():
            rates[number][numbers[target]] += count * repairs
    rows, lost = _over_mission(rates, failing)
    if not in_mission:
        repaired = after(repairs)
        mended = [[ZERO] * len(states) for _ in states]
        for number, row in enumerate(rows):
            for end, share in enumerate(row):
                if share:
                    for state, chance in units.mended(states[number], states[end], repaired):
                        mended[number][numbers[state]] += share * chance
        rows = mended
    return _long_run(rows, lost)


def _states(units: _Units, quantity: int) -> list[int]:
    """Return all that may have failed while the group works, from nothing on."""
    states = {0: None}
    waiting = [0]
    for state in waiting:
        following = [target for target, rate in units.failing(state) if rate]
        following += [target for target, _ in units.repairing(state)]
        for target in following:
            if target is not None and target not in states:
                states[target] = None
                waiting.append(target)
        if len(states) > MOST_STATES:
            raise HardwareError(
                f"{quantity} units are too many to follow with repair; allowed: {MOST_STATES} "
                "states of failed units, as 6 units that differ have; leave out 'repair' and "
                "state a 'test_interval', or describe the group as several components"
            )
    return list(states)


def _over_mission(rates: list[_Row], failing: _Row) -> tuple[list[_Row], _Row]:
    """Return from each state the chances of the others after a mission, and of the failure."""
    leaving = [sum(row, lost) for row, lost in zip(rates, failing, strict=True)]
    fastest = max(leaving)
    halvings = 0
    while fastest > _SHORT:
        fastest, halvings = fastest / 2, halvings + 1
    size = range(len(rates))
    if fastest == ZERO:
        return [[ONE if i == j else ZERO for j in size] for i in size], [ZERO] * len(rates)
    per_jump = fastest * 2**halvings
    jumps = [
        [
            (j, rate / per_jump)
            for j, rate in enumerate([*row, lost])
            if rate
        ]
        for row, lost in zip(rates, failing, strict=True)
    ]  # fmt: skip
    staying = [(per_jump - rate) / per_jump for rate in leaving]
    rows, lost = [], []
    for start in size:
        now = _after_jumps(start, jumps, staying, fastest)
        rows.append(now[:-1])
        lost.append(now[-1])
    for _ in range(halvings):
        lost = [
            before + sum((p * q for p, q in zip(row, lost, strict=True)), ZERO)
            for row, before in zip(rows, lost, strict=True)
        ]
        columns = list(zip(*rows, strict=True))
        rows = [
            [sum((p * q for p, q in zip(row, column, strict=True)), ZERO) for column in columns]
            for row in rows
        ]
    return rows, lost


def _after_jumps(
    start: int, jumps: list[list[tuple[int, Decimal]]], staying: _Row, mean: Decimal
) -> _Row:
    """Return where a chain is after a Poisson number of jumps; its last place is the failure."""
    size = len(jumps)
    now = [ONE if state == start else ZERO for state in range(size + 1)]
    weight = (-mean).exp()
    total = [weight * share for share in now]
    step, needed = 0, ZERO
    while True:
        following = [share * stay for share, stay in zip(now, [*staying, ONE], strict=True)]
        for share, ways in zip(now, jumps, strict=False):
            if share:
                for target, chance in ways:
                    following[target] += share * chance
        now = following
        step += 1
        weight *= mean / step
        total = [before + weight * share for before, share in zip(total, now, strict=True)]
        if step == size + 1:
            # From here on, each state that can be reached has been.
            needed = weight * _NEGLIGIBLE
        elif weight < needed:
            return total


def _long_run(rows: list[_Row], lost: _Row) -> Outcome:
    """Return which share of missions fails, of those between two at which nothing had failed."""
    missions, survived = [ONE] * len(rows), [sum(row, ZERO) for row in rows]
    for last in range(len(rows) - 1, 0, -1):
        leaving = lost[last] + sum(rows[last][:last], ZERO)
        for state in range(last):
            if not rows[state][last]:
                continue
            times = rows[state][last] / leaving
            lost[state] += times * lost[last]
            missions[state] += times * missions[last]
            survived[state] += times * survived[last]
            for target in range(last):
                rows[state][target] += times * rows[last][target]
    if lost[0] == ZERO:
        return NEVER
    return Outcome(lost[0] / missions[0], survived[0] / missions[0])
