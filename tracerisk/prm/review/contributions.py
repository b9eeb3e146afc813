"""What one change alone does to the mission's figure: the earlier model, with only it, solved."""

from __future__ import annotations

from collections.abc import Iterable

from tracerisk.errors import InputError
from tracerisk.prm.hybrid.mission import solve_mission
from tracerisk.prm.review.flow_changes import Edit
from tracerisk.prm.review.model_parts import ModelParts, RiskVersion


class Contributions:
    """Makes changes in the earlier version, one at a time."""

    def __init__(self, before: RiskVersion) -> None:
        self._before = before

    def of(self, edits: Iterable[Edit]) -> float | None:
        """Return what edits do; `None` where they alone make no model."""
        parts = ModelParts(self._before)
        for edit in edits:
            edit(parts)
        try:
            alone = solve_mission(parts.model()).failure.p
        except InputError:
            return None
        return alone - self._before.figures.mission.failure_probability
