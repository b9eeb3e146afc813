"""Run a controller, and draft what its mission is from what the run brought about."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.pipeline.mission.drafted import DraftedCondition, drafted_conditions
from tracerisk.pipeline.run.ended_run import Progress, RunOptions
from tracerisk.pipeline.run.fault_run import nominal_run
from tracerisk.pipeline.scenarios.text import with_entries
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.trace import EndCause, Trace
from tracerisk.twin.physics.scene import load_scene

_OVER: frozenset[EndCause] = frozenset({"ended", "quiescent", "idle"})


@dataclass(frozen=True, slots=True)
class SuccessDraft:
    """What a run brought about, as conditions of `success` that nobody has confirmed."""

    trace: Trace
    """The run."""
    conditions: tuple[DraftedCondition, ...]
    """What the scenario does not say yet; none of a run that is faulted or stuck."""
    text: str
    """The scenario with these conditions."""


def draft_success(
    controller: Controller,
    settings: Settings,
    base: Path | None,
    *,
    progress: Progress | None = None,
) -> SuccessDraft:
    """Run the controller and draft its mission; `base` is the scenario that is kept.

    Raises as `trace_controller`, and ScenarioError where the base cannot be read.
    """
    scenario = Scenario() if base is None else read_scenario(base)
    run = nominal_run(controller, settings, RunOptions(progress=progress))
    verdict, outcome = run.trace.verdict, run.trace.outcome
    conditions: tuple[DraftedCondition, ...] = ()
    if outcome is not None and verdict is not None and not verdict.is_bad:
        goals = load_scene(run.request.scene).goals
        is_over = run.trace.end.cause in _OVER
        conditions = drafted_conditions(outcome, goals, scenario.success, is_over=is_over)
    entries = [line for drafted in conditions for line in drafted.lines]
    return SuccessDraft(run.trace, conditions, with_entries(base, {"success": entries}))
