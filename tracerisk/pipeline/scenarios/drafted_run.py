"""Run a controller with what it lacks drafted, where it shows no risk without."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.config import Settings
from tracerisk.pipeline.run.attempts import OF_THE_MACHINE, trace_attempts
from tracerisk.pipeline.scenarios.rounds import ScenarioDraft, draft_scenario
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import INPUT_ASSUMED, Reason, Trace
from tracerisk.twin.robots.detect import SeveralRobotsError

if TYPE_CHECKING:
    from tracerisk.hardware.model import Hardware
    from tracerisk.pipeline.run.controller_run import Progress

_CONFIRM = "; delete its mark to confirm it"


def trace_drafting(
    controller: Controller,
    settings: Settings,
    *,
    hardware_of: Callable[[Settings, str], Hardware],
    keep: Path | None = None,
    progress: Progress | None = None,
) -> Trace:
    """Return what a run showed: as it is, else with what it lacked drafted.

    Only a run that shows no risk, for want of input or of one robot among several, is done again
    so. Then the trace is that of the drafted scenario: each value of it is a reason of the verdict,
    for nobody has confirmed it. Where no draft makes it show risk, all is as without.
    Raises what `trace_attempts` raises.
    """

    def run(settings: Settings, keep: Path | None) -> Trace:
        return trace_attempts(
            controller, settings, hardware_of=hardware_of, keep=keep, progress=progress
        )

    def drafted() -> Trace | None:
        base = None if settings.scenario is None else Path(settings.scenario)
        draft = draft_scenario(
            controller, settings, base, hardware_of=hardware_of, progress=progress
        )
        if draft.trace is None or not _shows_risk(draft.trace) or not _gives_something(draft):
            return None
        if keep is None:
            return _as_drafted(draft.trace)
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
            path = Path(folder, "scenario.yaml")
            path.write_text(draft.text, encoding="utf-8", newline="")
            robot = settings.robot or (None if draft.robot is None else draft.robot.name)
            return _as_drafted(run(replace(settings, scenario=str(path), robot=robot), keep))

    if not settings.draft:
        return run(settings, keep)
    try:
        trace = run(settings, keep)
    except SeveralRobotsError:
        more = drafted()
        if more is None:
            raise
        return more
    if _shows_risk(trace) or trace.end.cause in OF_THE_MACHINE or not _lacks_input(trace):
        return trace
    return drafted() or trace


def _shows_risk(trace: Trace) -> bool:
    return trace.is_usable and bool(trace.functions)


def _lacks_input(trace: Trace) -> bool:
    """Tell whether a run without risk may have lacked what a scenario can give.

    One that raised an error, and had asked for nothing in vain, has a fault of its own.
    """
    return trace.end.cause != "raised" or bool(trace.end.scenario)


def _gives_something(draft: ScenarioDraft) -> bool:
    return bool(draft.given or draft.robot is not None or draft.arguments is not None)


def _as_drafted(trace: Trace) -> Trace:
    """Return the trace without the places in a scenario that nobody has."""
    if trace.verdict is None:
        return trace

    def without_place(reason: Reason) -> Reason:
        if reason.code != INPUT_ASSUMED or not reason.words.endswith(_CONFIRM):
            return reason
        return replace(reason, location=None, words=reason.words.removesuffix(_CONFIRM))

    reasons = tuple(map(without_place, trace.verdict.reasons))
    return replace(trace, verdict=replace(trace.verdict, reasons=reasons))
