"""Run a controller with what it lacks drafted, where it shows no risk without."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.config import Settings
from tracerisk.errors import Location
from tracerisk.pipeline.run.attempts import OF_THE_MACHINE, trace_attempts
from tracerisk.pipeline.scenarios.rounds import ScenarioDraft, draft_scenario
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import INPUT_ASSUMED, Reason, Trace
from tracerisk.twin.robots.detect import SeveralRobotsError

if TYPE_CHECKING:
    from tracerisk.hardware.model import Hardware
    from tracerisk.pipeline.run.controller_run import Progress

_DRAFT = "scenario.yaml"
_ASSUMED = " of the scenario is assumed"
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
    for nobody has confirmed it. Where no draft makes it show risk without a fault, the first
    run's outcome stands.
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
        if draft.trace is None or not _is_of_use(draft):
            return None
        if keep is None:
            return _as_drafted(draft.trace)
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
            path = Path(folder, _DRAFT)
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


def _is_of_use(draft: ScenarioDraft) -> bool:
    """Tell whether something was drafted, and whether the run with it went well.

    A fault that comes after a drafted value says nothing of the controller's own mission.
    """
    trace = draft.trace
    has_values = bool(draft.given or draft.robot is not None or draft.arguments is not None)
    is_well = trace is not None and trace.verdict is not None and trace.verdict.kind == "partial"
    return has_values and is_well and trace is not None and _shows_risk(trace)


def _as_drafted(trace: Trace) -> Trace:
    """Return the trace without places in a scenario that is no file of the user's."""

    def place(location: Location | None) -> Location | None:
        is_drafted = location is not None and Path(location.file).name == _DRAFT
        return None if is_drafted else location

    def told(reason: Reason) -> Reason:
        words = reason.words
        if reason.code == INPUT_ASSUMED and words.endswith(_CONFIRM):
            words = words.removesuffix(_CONFIRM).replace(_ASSUMED, " is drafted", 1)
        return replace(reason, location=place(reason.location), words=words)

    verdict = trace.verdict
    if verdict is not None:
        verdict = replace(verdict, reasons=tuple(map(told, verdict.reasons)))
    findings = tuple(replace(each, location=place(each.location)) for each in trace.findings)
    return replace(trace, findings=findings, verdict=verdict)
