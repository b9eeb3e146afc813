"""Groups whose failures stay hidden until the mission ends: their value in each function.

Own derivation: docs/theory.md#groups.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from tracerisk.adder.quantify.function_use import FunctionUse
from tracerisk.adder.quantify.group_gates import (
    SURE,
    common_share,
    like_apart,
    threshold_of,
    unlike_apart,
)
from tracerisk.adder.quantify.outcome import ONE, ZERO, Outcome, after, fewer_than, solve_hazard
from tracerisk.adder.quantify.probability import survival_log
from tracerisk.adder.quantify.repaired_groups import EACH_MISSION, Renewal, repaired_group
from tracerisk.common.hardware.redundancy import Redundancy

_STEP = Decimal("1e-15")
"""The relative step of the finite difference; hazards have 40 digits."""


@dataclass(frozen=True, slots=True)
class HiddenHazards:
    """The hazards of one mean visit of a function."""

    own: tuple[Decimal, ...]
    """The hazard of each unit by itself [1], (n_units,)."""
    common: Decimal
    """The hazard of the common cause [1]; 0 where there is none."""
    times: Decimal
    """How often a mission visits the function."""


def hidden_hazards(
    each: FunctionUse, redundancy: Redundancy, without: int | None = None
) -> HiddenHazards:
    """Return the hazards of a mean visit of a function, but for those of the unit `without`."""
    beta = redundancy.common_cause if redundancy.is_redundant else 0.0
    own = []
    for number, column in enumerate(zip(*each.visits, strict=True)):
        parts = [0.0] if number == without else [-survival_log((1.0 - beta) * p) for p in column]
        own.append(_mean_hazard(parts))
    common = ZERO
    if beta:
        means = (
            math.fsum(p for number, p in enumerate(units) if number != without) / len(units)
            for units in each.visits
        )
        common = _mean_hazard([-survival_log(beta * mean) for mean in means])
    return HiddenHazards(tuple(own), common, Decimal(each.times))


def _mean_hazard(hazards: Sequence[float]) -> Decimal:
    total = math.fsum(hazards)
    return Decimal(total) / len(hazards) if total < SURE else SURE


def over_mission(functions: Sequence[HiddenHazards]) -> tuple[list[Outcome], Decimal]:
    """Return each unit's own outcome after all visits, and the hazard of the common cause."""
    columns = zip(*(function.own for function in functions), strict=True)
    times = [function.times for function in functions]
    own = [
        after(sum((h * n for h, n in zip(column, times, strict=True)), ZERO)) for column in columns
    ]
    return own, sum((function.common * function.times for function in functions), ZERO)


def hidden_values(
    functions: Sequence[FunctionUse],
    redundancy: Redundancy,
    quantity: int,
    renewal: Renewal = EACH_MISSION,
) -> tuple[float, ...]:
    """Return the values for groups whose failures stay hidden until a mission ends, or longer.

    Where they are found after several missions, or are repaired while others go on, the values
    give the mean hazard of the group in one of them.
    A function's part of the group's hazard is what it adds to it to first order: the hazards of
    its units, each by how much the group's failure depends on that unit.
    """
    hazards = [hidden_hazards(function, redundancy) for function in functions]
    own, common = over_mission(hazards)
    between_tests, of_mission = Decimal(renewal.missions), own
    if renewal.missions != 1.0:
        own = [after(unit.hazard * between_tests) for unit in own]
    apart = unlike_apart(own, redundancy)
    if renewal.repair is not None:
        target = repaired_hazard(of_mission, redundancy, renewal, renewal.repair) + common
    else:
        target = (apart.hazard if apart.q else SURE) / between_tests + common
    if target == ZERO:
        return (0.0,) * len(functions)
    slopes = _slopes(own, redundancy, apart)
    weights = [
        sum((slope * h for slope, h in zip(slopes, hazard.own, strict=True)), hazard.common)
        for hazard in hazards
    ]
    whole = sum(
        (weight * hazard.times for weight, hazard in zip(weights, hazards, strict=True)), ZERO
    )
    shares = [weight / whole for weight in weights]
    if apart.q == ZERO:
        return tuple(float(after(SURE * share).p) for share in shares)
    beta = common_share(redundancy)

    def like(x: Decimal) -> Decimal:
        own_hazard, common_hazard = x, ZERO
        if beta:
            units = [
                (after(x * share), hazard.times)
                for share, hazard in zip(shares, hazards, strict=True)
            ]
            own_hazard, common_hazard = (
                sum((unit.share(part).hazard * times for unit, times in units), ZERO)
                for part in (ONE - beta, beta)
            )
        return like_apart(after(own_hazard), redundancy, quantity).hazard + common_hazard

    start = sum((unit.hazard for unit in own), common) / quantity / between_tests
    x = solve_hazard(like, target, start)
    return tuple(float(after(x * share).p) for share in shares)


def repaired_hazard(
    own: Sequence[Outcome], redundancy: Redundancy, renewal: Renewal, repair: float
) -> Decimal:
    """Return the hazard of a repaired group in the mean mission, by its units' own failures.

    `own` are their outcomes in one mission.
    """
    group = repaired_group(own, redundancy, repair, in_mission=renewal.in_mission)
    return group.hazard if group.q else SURE


def _slopes(own: Sequence[Outcome], redundancy: Redundancy, apart: Outcome) -> list[Decimal]:
    """Return the derivatives of the group's hazard by those of its units."""
    if apart.q == ZERO:
        return [ONE] * len(own)
    if redundancy.has_spares:
        units = range(len(own))
        return [_slope_of_spares(own, redundancy, apart, number) for number in units]
    threshold = threshold_of(redundancy, len(own))
    slopes = []
    for number, unit in enumerate(own):
        others = fewer_than(threshold, [*own[:number], *own[number + 1 :]])
        slopes.append(others[-1] * unit.q / apart.q)
    return slopes


def _slope_of_spares(
    own: Sequence[Outcome], redundancy: Redundancy, apart: Outcome, number: int
) -> Decimal:
    """Return the derivative of the hazard of a group with spares by a difference."""
    hazard = own[number].hazard
    if hazard == ZERO or hazard >= SURE:
        return ZERO
    more = [*own[:number], after(hazard * (ONE + _STEP)), *own[number + 1 :]]
    return (unlike_apart(more, redundancy).hazard - apart.hazard) / (_STEP * hazard)
