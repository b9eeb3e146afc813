"""What each unit of a group contributes to its failures over a mission.

Own derivation: docs/theory.md#instances.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from tracerisk.adder.quantify.function_use import FunctionUse, mission_hazard, mission_probability
from tracerisk.adder.quantify.group_gates import (
    SURE,
    needs_all,
    stays_hidden,
    unlike_apart,
    unlike_visit,
)
from tracerisk.adder.quantify.hidden_groups import hidden_hazards, over_mission
from tracerisk.adder.quantify.outcome import ZERO, with_digits
from tracerisk.common.hardware.redundancy import Redundancy


@dataclass(frozen=True, slots=True)
class InstanceShare:
    """What one unit contributes to the failures of its group over a mission."""

    p_failure: float
    """The unit's own failure probability over the mission."""
    fussell_vesely: float
    """The share of the group's hazard that goes with the unit, from 0 to 1."""
    share: float
    """The same share, scaled so that all units sum to 1."""


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


def _drops(
    functions: Sequence[FunctionUse], redundancy: Redundancy, quantity: int
) -> list[Decimal]:
    """Return the relative drop of the group's hazard when each unit in turn is perfect."""
    if needs_all(redundancy, quantity) and not redundancy.common_cause:
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


def _mission_hazard(
    functions: Sequence[FunctionUse], redundancy: Redundancy, quantity: int, without: int | None
) -> Decimal:
    """Return the hazard of the group over a mission, one unit of it being perfect."""
    if stays_hidden(redundancy, quantity):
        own, common = over_mission(
            [hidden_hazards(function, redundancy, without) for function in functions]
        )
        apart = unlike_apart(own, redundancy)
        return (apart.hazard if apart.q else SURE) + common
    return sum(
        (
            Decimal(function.scale)
            * times
            * min(unlike_visit(units, redundancy, without).hazard, SURE)
            for function in functions
            for units, times in Counter(map(tuple, function.visits)).items()
        ),
        ZERO,
    )
