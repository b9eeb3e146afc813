"""What one change alone does to the mission's figure: the earlier model, with only it, solved."""

from __future__ import annotations

from collections.abc import Iterable

from tracerisk.errors import InputError
from tracerisk.prm.flow_changes import Edit
from tracerisk.prm.hybrid import HybridModel
from tracerisk.prm.mission import solve_mission
from tracerisk.prm.model_parts import ModelParts, RiskVersion
from tracerisk.prm.solve import top_event


class Contributions:
    """Makes changes in the earlier version, one at a time."""

    def __init__(self, before: RiskVersion) -> None:
        self._before = before
        reached = set(before.model.reachable)
        self._tops = {
            state.name: top_event(state) for state in before.model.states if state.name in reached
        }

    def of_components(self, edits: Iterable[Edit], functions: Iterable[str]) -> float | None:
        """Return what edits of components of these functions do.

        They leave the chain as it is, so that only the functions' top events are new.
        `None` where they alone make no model.
        """
        parts = ModelParts(self._before)
        for edit in edits:
            edit(parts)
        tops = dict(self._tops)
        try:
            for name in functions:
                if name in tops:
                    tops[name] = top_event(parts.state(name))
            alone = solve_mission(self._before.model, tops).failure.p
        except InputError:
            return None
        return alone - self._mission()

    def of_flow(self, edits: Iterable[Edit]) -> float | None:
        """Return what edits of the chain do; `None` where they alone make no model."""
        parts = ModelParts(self._before)
        for edit in edits:
            edit(parts)
        try:
            alone = _mission_failure(parts.model())
        except InputError:
            return None
        return alone - self._mission()

    def _mission(self) -> float:
        return self._before.figures.mission.failure_probability


def _mission_failure(model: HybridModel) -> float:
    reached = set(model.reachable)
    tops = {state.name: top_event(state) for state in model.states if state.name in reached}
    return solve_mission(model, tops).failure.p
