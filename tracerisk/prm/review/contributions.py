"""What one change alone does to the mission's figures: the earlier model, with only it, solved."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from tracerisk.errors import InputError
from tracerisk.prm.hybrid.chain_solver import held_reading, mission_figures, solve_mission
from tracerisk.prm.review.flow_changes import Edit
from tracerisk.prm.review.model_parts import ModelParts, RiskVersion


class Contribution(NamedTuple):
    """What edits of the earlier version alone do; `None` for what they leave unknown."""

    failure: float | None
    """By how much the mission's failure probability rises."""
    undetected: float | None
    """By how much the undetected failure rises."""


def contribution(before: RiskVersion, edits: Iterable[Edit]) -> Contribution:
    """Return what edits of the earlier version do; nothing is known where they make no model."""
    parts = ModelParts(before)
    for edit in edits:
        edit(parts)
    try:
        model = parts.model()
        solved = solve_mission(model)
        reading, alone = held_reading(model, solved)
    except InputError:
        return Contribution(None, None)
    mission = before.figures.mission
    # The same edits may make the numbers of cycles fixed, or vary: that is no cause of risk.
    is_same = reading == mission.reading
    undetected = None
    if mission.undetected_probability is not None:
        now, was = mission_figures(model, solved), mission
        if not is_same:
            now, was = now.as_geometric(), was.as_geometric()
        if now.undetected_probability is not None and was.undetected_probability is not None:
            undetected = now.undetected_probability - was.undetected_probability
    failure = (
        alone.p - mission.failure_probability
        if is_same
        else solved.failure.p - mission.geometric_cycles
    )
    return Contribution(failure, undetected)
