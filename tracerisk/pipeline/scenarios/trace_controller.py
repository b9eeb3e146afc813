"""Run a controller on the twin, with a draft of what its world lacks, or on real rospy."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_runs
from tracerisk.config import Settings
from tracerisk.errors import ControllerFailedError, InputError, Location, TraceRiskError
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.trace import Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.run.ended_run import Progress

_NO_FAILURE = frozenset({"assumed_name", "assumed_setting", "assumed_start", "unused"})
"""Kinds of findings that say what was assumed, and not what went wrong."""


def trace_controller(
    controller: Controller,
    settings: Settings,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    live_speed: float | None = None,
) -> Trace:
    """Run the controller on the twin and return what the run showed.

    With `live_speed` it runs once on real rospy, at most so many times as fast as the wall clock.
    A run that ends badly gives a trace too, as far as it came: see `Trace.end`.
    `keep` is a folder in which the recording stays.
    What is assumed of its robot and its launch file is tried again where the run shows that it
    does not fit: see `Trace.assumptions`. What it asks its world for in vain is drafted where it
    would show no risk without, and the settings do not say otherwise: see `Trace.drafted`.
    Raises SourceError, RobotError, HardwareError before anything runs, and as `require_runs`.
    """
    if not controller.is_python:
        raise InputError(
            "is C or C++, which is not run on the twin; give the log or trace of its own run: "
            "`tracerisk annotate FILE --log LOG` or `--trace TRACE`",
            Location(str(controller.path)),
        )
    require_runs("running a controller")
    from tracerisk.pipeline.run.ended_run import RunOptions

    options = RunOptions(
        keep,
        progress,
        live_speed=live_speed,
        meanwhile=lambda: _read_ahead(controller),
        is_replayed=True,
    )
    if live_speed is not None:
        from tracerisk.pipeline.run.live.live_trace import trace_live

        return trace_live(controller, settings, options)
    from tracerisk.pipeline.scenarios.drafted_run import trace_with_draft

    return trace_with_draft(controller, settings, options)


def _read_ahead(controller: Controller) -> None:
    """Read of the source what coverage and blocks need of it, for which the run need not end."""
    from tracerisk.adder.sources.positions import function_sites
    from tracerisk.instrument.source.call_graph import call_graph

    with contextlib.suppress(TraceRiskError):
        call_graph(controller.source, controller.file)
    function_sites(controller.source)


def nothing_commanded(trace: Trace, controller: Controller) -> ControllerFailedError:
    """Return the error of a run in which no hardware was commanded, with what it showed instead."""
    message = f"{trace.end.message}, and it commanded no hardware: there is no risk to assess"
    if trace.verdict is not None and trace.verdict.coverage.never_ran_words:
        message = f"{message}; {trace.verdict.coverage.never_ran_words}"
    if not trace.findings:
        hint = "does it need arguments (after --) or answers (--answer)?"
        start = Location(str(controller.path), 1)
        return ControllerFailedError(f"{message}; {hint}", start, trace.end.scenario)
    # What went wrong says more than what was assumed before it.
    first = min(trace.findings, key=lambda finding: finding.kind in _NO_FAILURE)
    more = len(trace.findings) - 1
    also = f" (and {more} more, which `tracerisk trace {controller.path}` prints)" if more else ""
    location = first.location
    place = (
        None if location is None else replace(location, file=str(controller.path_of(location.file)))
    )
    return ControllerFailedError(f"{message}; {first.message}{also}", place, trace.end.scenario)
