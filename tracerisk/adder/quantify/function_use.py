"""How the units of a component fail in the visits of one function."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tracerisk.adder.quantify.probability import survival_log

Visits = Sequence[Sequence[float]]
"""For each visit the failure probability of each unit of the group."""


@dataclass(frozen=True, slots=True)
class FunctionUse:
    """What the units of one group did in one function."""

    visits: Visits
    """The failure probability of each unit in each visit of the trace, (n_visits, n_units)."""
    times: float
    """How often a mission visits the function; the visits are a sample of these."""

    @property
    def scale(self) -> float:
        """How many visits of a mission each of `visits` stands for."""
        return self.times / len(self.visits)


def mission_probability(functions: Sequence[FunctionUse], unit: int) -> float:
    """Return the failure probability of one unit of a group over a mission."""
    return 0.0 - math.expm1(-mission_hazard(functions, unit))


def mission_hazard(functions: Sequence[FunctionUse], unit: int) -> float:
    """Return the hazard of one unit of a group over a mission."""
    logs = (
        function.scale * survival_log(units[unit])
        for function in functions
        for units in function.visits
    )
    return 0.0 - math.fsum(logs)


def mean_probability(visits: Visits) -> float:
    """Return the failure probability of the mean hazard over visits and units."""
    total = math.fsum(survival_log(p) for units in visits for p in units)
    return 0.0 - math.expm1(total / math.fsum(len(units) for units in visits))
