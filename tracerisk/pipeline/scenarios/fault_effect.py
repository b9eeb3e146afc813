"""Run a controller without faults and with some, where the run without shows risk."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tracerisk.errors import InputError
from tracerisk.pipeline.run import fault_run
from tracerisk.pipeline.run.ended_run import Progress, RunOptions
from tracerisk.pipeline.run.fault_run import FaultRun, nominal_run
from tracerisk.pipeline.scenarios.trace_controller import nothing_commanded
from tracerisk.pipeline.workspace.controller import forbid_compiled, load_controller
from tracerisk.trace import RunFailedError, Trace
from tracerisk.twin.faults.fault import parse_fault


def run_with_faults(
    path: str | Path,
    faults: Sequence[str],
    settings: Mapping[str, Any] | None = None,
    *,
    keep: Path | None = None,
    progress: Progress | None = None,
    on_nominal: Callable[[Trace], None] | None = None,
) -> FaultRun:
    """Run a controller, and once more with faults; see `tracerisk.api.run_with_faults`."""
    parsed = [parse_fault(fault) for fault in faults]
    if not parsed:
        raise InputError("no fault is given; expected UNIT:MODE@SECONDS")
    controller = load_controller(path)
    loaded = controller.settings_with(settings)
    forbid_compiled(path, "a run with a fault")
    nominal = nominal_run(controller, loaded, RunOptions(progress=progress))
    if not nominal.trace.is_usable:
        raise RunFailedError(nominal.trace)
    if not nominal.trace.functions:
        raise nothing_commanded(nominal.trace, controller)
    if on_nominal is not None:
        on_nominal(nominal.trace)
    return fault_run.run_with_faults(
        controller, loaded, nominal, parsed, RunOptions(keep, progress)
    )
