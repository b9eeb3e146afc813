"""Which part of a component's hazard goes with each of its figures, and which ends missions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from tracerisk.adder.quantify.component_activity import ComponentUse


def figure_shares(used: ComponentUse, times: Mapping[int, float]) -> tuple[float, ...]:
    """Return the share of each figure in the hazard of the units over a mission.

    `times` says how often each visit comes in a mission, by its number in the trace; visits
    that it leaves out do not count. In the order of the component's figures, summing to one, except
    where nothing can fail.
    Raises UnknownUseError where the trace does not hold what a figure counts.
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


@dataclass(frozen=True, slots=True)
class EndingShare:
    """The share of a component's hazard that ends the mission, as drawn failures show it."""

    share: float
    """The share, from 0 to 1."""
    cells: float
    """The number of equal draws with the same uncertainty: the effective sample size (Kish, Survey
    Sampling, 1965)."""


def ending_share(used: ComponentUse, times: Mapping[int, float]) -> EndingShare | None:
    """Return which share of a component's hazard ends the mission; `None` without evidence.

    `times` as in `figure_shares`. Raises UnknownUseError as well.
    """
    weights: dict[tuple[str, int], float] = {}
    all_of_it = ending = 0.0
    for unit in used.units:
        for term in unit.terms:
            known = bool(term.ends)
            for visit, comes in times.items():
                if comes <= 0.0:
                    continue
                hazard = comes * replace(term, ends=()).hazard(unit.uses[visit])
                all_of_it += hazard
                ending += hazard * term.ends[visit] if known else hazard
                if known:
                    weights[term.cells] = weights.get(term.cells, 0.0) + hazard
    spread = math.fsum(weight**2 / cells for (_, cells), weight in weights.items() if cells)
    if not spread > 0.0 or not math.isfinite(all_of_it):
        return None
    return EndingShare(ending / all_of_it, all_of_it**2 / spread)
