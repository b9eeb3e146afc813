"""Which part of a component's hazard goes with each of its figures."""

from __future__ import annotations

import math
from collections.abc import Mapping

from tracerisk.quantify.mission import ComponentUse


def figure_shares(used: ComponentUse, times: Mapping[int, float]) -> tuple[float, ...]:
    """Return the share of each figure in the hazard of the units over a mission.

    `times` says how often each visit comes in a mission, by its number in the trace; visits
    that it leaves out do not count. In the order of the component's figures, summing to one but
    where nothing can fail.
    Raises UnknownUseError where the trace does not tell what a figure counts.
    """
    figures = used.component.figures
    if len(figures) == 1:
        return (1.0,)
    hazards = [
        math.fsum(
            comes * term.hazard(unit.uses[visit])
            for unit in used.units
            for term in unit.terms
            if term.figure is figure
            for visit, comes in times.items()
            if comes > 0.0
        )
        for figure in figures
    ]
    if math.inf in hazards:
        hazards = [float(hazard == math.inf) for hazard in hazards]
    total = math.fsum(hazards)
    return tuple(hazard / total if total else 0.0 for hazard in hazards)
