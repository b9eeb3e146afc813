"""Run a controller on the twin, with a draft of what its world lacks, or on real ROS."""

from __future__ import annotations

import contextlib
import os
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tracerisk.common.dependencies import require_runs
from tracerisk.config import Settings
from tracerisk.errors import ControllerFailedError, InputError, Location, TraceRiskError
from tracerisk.pipeline.freshness.run_inputs import files_named
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

    With `live_speed` it runs once on real ROS, at most so many times as fast as the wall clock.
    A run that ends badly gives a trace too, as far as it came: see `Trace.end`.
    `keep` is a folder in which the recording stays.
    What is assumed of its robot and its launch file is tried again where the run shows that it
    does not fit: see `Trace.assumptions`. What it asks its world for in vain is drafted where it
    would show no risk without, and the settings do not say otherwise: see `Trace.drafted`.
    Raises SourceError, RobotError, HardwareError before anything runs, InputError where a file
    that it read was changed meanwhile, and as `require_runs`.
    """
    if not controller.is_python and live_speed is None:
        raise InputError(
            "is C or C++: --live runs its node on the twin, "
            f"`tracerisk run {controller.path}{controller.live_words}`; or give the log or trace "
            "of its own run: `tracerisk annotate FILE --log LOG` or `--trace TRACE`",
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

    began = _clocks()
    trace = trace_with_draft(controller, settings, options)
    _forbid_changed(trace, controller, settings, began)
    return trace


class _Clocks(NamedTuple):
    of_day_ns: int
    """What dates files; somebody may set it at any time."""
    running_ns: int
    """What nobody sets."""


def _clocks() -> _Clocks:
    return _Clocks(time.time_ns(), time.monotonic_ns())


def _forbid_changed(
    trace: Trace, controller: Controller, settings: Settings, began: _Clocks
) -> None:
    """Raise InputError where a file that a run read was changed since it began.

    Nobody knows which of its contents the run read. Sources need none of it, for the recording
    holds them. Without a sandbox, the controller itself may have written the file.
    """
    from tracerisk.common.sandbox.process import is_contained

    if not is_contained(settings.limits.sandbox):
        return
    ended = _clocks()
    lasted_ns = ended.running_ns - began.running_ns
    # If the clock was set meanwhile, files bear dates by the one before, or by the one since.
    spans = (began.of_day_ns, lasted_ns), (ended.of_day_ns - lasted_ns, lasted_ns)
    root = controller.root.resolve()
    read = {*trace.inputs, *files_named(controller, settings)} - {controller.file, *trace.files}
    written = [Path(folder).resolve() for folder in settings.writable]
    for path in (Path(os.path.normpath(root / file)) for file in sorted(read)):
        with contextlib.suppress(OSError):
            is_own = any(map(path.is_relative_to, written))
            changed_ns = path.stat().st_ctime_ns
            if not is_own and any(0 < changed_ns - first <= lasted for first, lasted in spans):
                raise InputError(
                    "was changed while the run went on; run the same command again",
                    Location(os.path.relpath(path)),
                )


def _read_ahead(controller: Controller) -> None:
    """Read of the source what coverage and blocks need of it, for which the run need not end."""
    from tracerisk.adder.sources.positions import function_sites
    from tracerisk.instrument.source.call_graph import call_graph

    if not controller.is_python:
        return
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
    again = f"`tracerisk trace {controller.path}{controller.live_words}`"
    also = f" (and {more} more, which {again} prints)" if more else ""
    location = first.location
    place = (
        None if location is None else replace(location, file=str(controller.path_of(location.file)))
    )
    return ControllerFailedError(f"{message}; {first.message}{also}", place, trace.end.scenario)
