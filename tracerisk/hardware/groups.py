"""The one unit probability that a block holds for units that differ, over several visits.

Own derivation: docs/theory.md#groups. A gate's failures over visits, as the model computes them
for like units at the block's value, are those that the unlike units give.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from tracerisk.hardware.outcome import (
    NEVER,
    ONE,
    SURELY,
    ZERO,
    Outcome,
    after,
    at_least,
    at_least_of_like,
    fewer_than,
    solve_hazard,
    with_digits,
)
from tracerisk.hardware.probability import survival_log
from tracerisk.hardware.redundancy import Redundancy
from tracerisk.hardware.spare_units import like_spares, unlike_spares

Visits = Sequence[Sequence[float]]
"""For each visit the failure probability of each unit of the group."""

_SURE = Decimal(5000)
"""The hazard of a certain failure where shares of it are needed: it survives once in 1e2171."""


@dataclass(frozen=True, slots=True)
class FunctionUse:
    """What the units of one group did in one function: see `Visits`.

    `times` is how often a mission visits the function; the visits are a sample of these.
    """

    visits: Visits
    times: float

    @property
    def scale(self) -> float:
        """How many visits of a mission each of `visits` stands for."""
        return self.times / len(self.visits)


def group_unit_probability(visits: Visits, redundancy: Redundancy) -> float:
    """Return the one unit probability that stands for unequal units over the visits.

    It is that of a mission which has these visits and no others: see `group_unit_probabilities`.
    """
    return group_unit_probabilities([FunctionUse(visits, len(visits))], redundancy)[0]


@with_digits
def group_unit_probabilities(
    functions: Sequence[FunctionUse], redundancy: Redundancy
) -> tuple[float, ...]:
    """Return for each function the one unit probability that stands for unequal units there.

    A group that is whole again at each visit, or needs every unit, fails over the visits of each
    function as its units do. One whose failures stay hidden does so over the mission, and the
    functions share its hazard by what each contributes: a failure hidden in one is there in the
    next, so that no function has a figure of its own.
    Units that are alike in all visits give back their probability.
    Raises HardwareError where spares that differ are too many to follow.
    """
    quantity = len(functions[0].visits[0])
    if all(len(set(units)) == 1 for each in functions for units in each.visits):
        alone = [_of_one_unit(each, redundancy) for each in functions]
        found = [value for value in alone if value is not None]
        if len(found) == len(alone):
            return tuple(found)
    if quantity == 1 or (_needs_all(redundancy, quantity) and not redundancy.common_cause):
        return tuple(mean_probability(each.visits) for each in functions)
    if _stays_hidden(redundancy, quantity):
        return _hidden(functions, redundancy, quantity)
    return tuple(_renewed(each.visits, redundancy, quantity) for each in functions)


@dataclass(frozen=True, slots=True)
class InstanceShare:
    """What one unit contributes to the failures of its group over a mission.

    `p_failure` is its own failure probability over the mission. `fussell_vesely` is the share of
    the group's hazard that goes with the unit, `share` the same such that those of all units sum
    to one.
    """

    p_failure: float
    fussell_vesely: float
    share: float


@with_digits
def instance_shares(
    functions: Sequence[FunctionUse], redundancy: Redundancy
) -> tuple[InstanceShare, ...]:
    """Return what each unit of a group contributes over a mission, in the order of the units."""
    quantity = len(functions[0].visits[0])
    drops = _drops(functions, redundancy, quantity)
    total = sum(drops, ZERO)
    return tuple(
        InstanceShare(
            mission_probability(functions, unit),
            float(drop),
            float(drop / total) if total else 0.0,
        )
        for unit, drop in enumerate(drops)
    )


def mission_probability(functions: Sequence[FunctionUse], unit: int) -> float:
    """Return the failure probability of one unit of a group over a mission."""
    return 0.0 - math.expm1(-mission_hazard(functions, unit))


def mission_hazard(functions: Sequence[FunctionUse], unit: int) -> float:
    """Return the hazard of one unit of a group over a mission."""
    logs = (each.scale * survival_log(units[unit]) for each in functions for units in each.visits)
    return 0.0 - math.fsum(logs)


def mean_probability(visits: Visits) -> float:
    """Return the failure probability of the mean hazard over visits and units."""
    total = math.fsum(survival_log(p) for units in visits for p in units)
    return 0.0 - math.expm1(total / math.fsum(len(units) for units in visits))


def _drops(
    functions: Sequence[FunctionUse], redundancy: Redundancy, quantity: int
) -> list[Decimal]:
    """Return by how much the group's hazard falls with each unit perfect, relative."""
    if _needs_all(redundancy, quantity) and not redundancy.common_cause:
        # The hazards of units that are each needed add up: each takes its own with it.
        own = [mission_hazard(functions, unit) for unit in range(quantity)]
        total = math.fsum(own)
        if math.isfinite(total):
            return [Decimal(hazard / total if total else 0.0) for hazard in own]
    whole = _mission_hazard(functions, redundancy, quantity, None)
    if whole == ZERO:
        return [ZERO] * quantity
    return [
        (whole - _mission_hazard(functions, redundancy, quantity, unit)) / whole
        for unit in range(quantity)
    ]


def _needs_all(redundancy: Redundancy, quantity: int) -> bool:
    return not redundancy.is_redundant or redundancy.required >= quantity


def _stays_hidden(redundancy: Redundancy, quantity: int) -> bool:
    return (
        not _needs_all(redundancy, quantity)
        and not redundancy.has_spares
        and redundancy.detected == "mission_start"
    )


def _of_one_unit(each: FunctionUse, redundancy: Redundancy) -> float | None:
    """Return the probability of like units in one function, where no gate is needed for it."""
    values = {units[0] for units in each.visits}
    if len(values) == 1:
        return values.pop()
    plain = not redundancy.is_redundant or (
        redundancy.detected == "mission_start"
        and not redundancy.has_spares
        and not redundancy.common_cause
    )
    return mean_probability(each.visits) if plain else None


def _outcome(p: float) -> Outcome:
    return Outcome(Decimal(p), ONE - Decimal(p)) if p < 1.0 else SURELY


def _unlike(units: Sequence[float], redundancy: Redundancy, without: int | None = None) -> Outcome:
    """Return the outcome of one visit of a group that is whole at its start.

    The common cause is that of a unit with the mean of their probabilities, which adds up over
    visits and units as no other mean does. It goes with no single unit: `without` one, the others
    share it.
    """
    beta = _beta(redundancy)
    own = [_outcome(p).share(ONE - beta) for p in units]
    if without is not None:
        own[without] = NEVER
    if redundancy.has_spares:
        apart = unlike_spares([each.hazard for each in own], redundancy)
    else:
        apart = at_least(_threshold(redundancy, len(units)), own)
    return apart.either(_common(units, redundancy, without))


def _like(unit: Outcome, redundancy: Redundancy, quantity: int) -> Outcome:
    """Return the same for like units, as the model has it."""
    beta = _beta(redundancy)
    own = unit.share(ONE - beta)
    if redundancy.has_spares:
        apart = like_spares(own.hazard, quantity, redundancy)
    else:
        apart = at_least_of_like(_threshold(redundancy, quantity), quantity, own)
    return apart.either(unit.share(beta))


def _beta(redundancy: Redundancy) -> Decimal:
    """Return the share of the common cause, which units that are all needed have not."""
    return Decimal(redundancy.common_cause if redundancy.is_redundant else 0.0)


def _threshold(redundancy: Redundancy, quantity: int) -> int:
    return 1 if _needs_all(redundancy, quantity) else quantity - redundancy.required + 1


def _common(units: Sequence[float], redundancy: Redundancy, without: int | None = None) -> Outcome:
    kept = [p for number, p in enumerate(units) if number != without]
    mean = sum(map(Decimal, kept), ZERO) / len(units)
    return Outcome(mean, ONE - mean).share(_beta(redundancy))


def _renewed(visits: Visits, redundancy: Redundancy, quantity: int) -> float:
    """Return the value for groups that are whole again at each visit."""
    target = sum((_unlike(units, redundancy).hazard for units in visits), ZERO) / len(visits)
    if target == ZERO:
        return 0.0
    if target.is_infinite():
        return 1.0
    return _probability(
        solve_hazard(lambda x: _like(after(x), redundancy, quantity).hazard, target, _start(visits))
    )


def _start(visits: Visits) -> Decimal:
    """Return a hazard near that of like units: the mean over visits and units."""
    hazards = [-survival_log(p) for units in visits for p in units]
    return min(max(Decimal(math.fsum(hazards)) / len(hazards), Decimal("1e-400")), Decimal(30))


def _probability(hazard: Decimal) -> float:
    return float(after(hazard).p)


@dataclass(frozen=True, slots=True)
class _HiddenHazards:
    """The hazards of one mean visit of a function: of each unit by itself, and the common one."""

    own: tuple[Decimal, ...]
    common: Decimal
    times: Decimal


def _hazards(
    each: FunctionUse, redundancy: Redundancy, without: int | None = None
) -> _HiddenHazards:
    beta = _beta(redundancy)
    visits = len(each.visits)
    own = []
    for number, column in enumerate(zip(*each.visits, strict=True)):
        parts = (min(_outcome(p).share(ONE - beta).hazard, _SURE) for p in column)
        own.append(ZERO if number == without else sum(parts, ZERO) / visits)
    common = ZERO
    if beta:
        parts = (min(_common(units, redundancy, without).hazard, _SURE) for units in each.visits)
        common = sum(parts, ZERO) / visits
    return _HiddenHazards(tuple(own), common, Decimal(each.times))


def _over_mission(functions: Sequence[_HiddenHazards]) -> tuple[list[Outcome], Decimal]:
    """Return each unit's own outcome after all visits, and the hazard of the common cause."""
    columns = zip(*(each.own for each in functions), strict=True)
    times = [each.times for each in functions]
    own = [
        after(sum((h * n for h, n in zip(column, times, strict=True)), ZERO)) for column in columns
    ]
    return own, sum((each.common * each.times for each in functions), ZERO)


def _hidden(
    functions: Sequence[FunctionUse], redundancy: Redundancy, quantity: int
) -> tuple[float, ...]:
    """Return the values for groups whose failures stay hidden until the mission ends.

    A function's part of the group's hazard is what it adds to it to first order: the hazards of
    its units, each by how much the group's failure depends on that unit.
    """
    threshold = _threshold(redundancy, quantity)
    hazards = [_hazards(each, redundancy) for each in functions]
    own, common = _over_mission(hazards)
    apart = at_least(threshold, own)
    target = apart.hazard + common
    if target == ZERO:
        return (0.0,) * len(functions)
    slopes = []
    for number, unit in enumerate(own):
        others = fewer_than(threshold, [*own[:number], *own[number + 1 :]])
        slopes.append(others[-1] * unit.q / apart.q)
    weights = [
        sum((slope * h for slope, h in zip(slopes, each.own, strict=True)), each.common)
        for each in hazards
    ]
    whole = sum((weight * each.times for weight, each in zip(weights, hazards, strict=True)), ZERO)
    shares = [weight / whole for weight in weights]
    beta = _beta(redundancy)

    def like(x: Decimal) -> Decimal:
        own_hazard, common_hazard = x, ZERO
        if beta:
            units = [after(x * share) for share in shares]
            own_hazard = sum(
                (
                    unit.share(ONE - beta).hazard * each.times
                    for unit, each in zip(units, hazards, strict=True)
                ),
                ZERO,
            )
            common_hazard = sum(
                (
                    unit.share(beta).hazard * each.times
                    for unit, each in zip(units, hazards, strict=True)
                ),
                ZERO,
            )
        return at_least_of_like(threshold, quantity, after(own_hazard)).hazard + common_hazard

    start = sum((unit.hazard for unit in own), common) / quantity
    x = solve_hazard(like, target, start)
    return tuple(_probability(x * share) for share in shares)


def _mission_hazard(
    functions: Sequence[FunctionUse], redundancy: Redundancy, quantity: int, without: int | None
) -> Decimal:
    """Return the hazard of the group over a mission, one unit of it being perfect."""
    if _stays_hidden(redundancy, quantity):
        own, common = _over_mission([_hazards(each, redundancy, without) for each in functions])
        return at_least(_threshold(redundancy, quantity), own).hazard + common
    return sum(
        (
            Decimal(each.scale) * min(_unlike(units, redundancy, without).hazard, _SURE)
            for each in functions
            for units in each.visits
        ),
        ZERO,
    )
