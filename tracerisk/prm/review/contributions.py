"""What one change alone does to the mission's figure: the earlier model, with only it, solved."""

from __future__ import annotations

from collections.abc import Iterable

from tracerisk.errors import InputError
from tracerisk.prm.hybrid.chain_solver import held_reading, solve_mission
from tracerisk.prm.review.flow_changes import Edit
from tracerisk.prm.review.model_parts import ModelParts, RiskVersion


def contribution(before: RiskVersion, edits: Iterable[Edit]) -> float | None:
    """Return what edits of the earlier version do; `None` where they alone make no model."""
    parts = ModelParts(before)
    for edit in edits:
        edit(parts)
    try:
        model = parts.model()
        solved = solve_mission(model)
        reading, alone = held_reading(model, solved)
    except InputError:
        return None
    mission = before.figures.mission
    if reading != mission.reading:
        # The same edits make the numbers of cycles fixed, or vary: that is no cause of risk.
        return solved.failure.p - mission.geometric_cycles
    return alone.p - mission.failure_probability
