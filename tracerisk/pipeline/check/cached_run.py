"""The run behind a controller's blocks, as it is cached: no simulation is needed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, lock_key
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.check.check import given_options
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.freshness.trace_cache import TraceCache
from tracerisk.pipeline.trace.kept_verdict import kept_verdict
from tracerisk.pipeline.trace.summary import trace_summary
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.trace import Trace

_TOLD = ("robot", "scene", "end")
"""What the lock keeps of a run as it is."""


@dataclass(frozen=True, slots=True)
class KeptRun:
    """A controller, the settings of its last run, and the trace of that run."""

    controller: Controller
    """The controller as it is now."""
    settings: Settings
    """The settings of its last run; those of now where the lock knows none."""
    files: tuple[str, ...]
    """The files with its risk blocks, as messages call them, the controller among them."""
    trace: Trace | None
    """The trace of the last run; `None` where it is stale or not kept."""
    reason: str = ""
    """Why `trace` is `None`, as a sentence; empty where there is a trace."""
    fingerprint: str = ""
    """The fingerprint of the last run; empty where `trace` was not looked up."""
    has_options: bool = False
    """Whether the last run had settings from its command line."""


def kept_run(path: Path | str) -> KeptRun:
    """Return what is kept of the last run of the controller at `path`.

    A trace that the sources have outrun is none. Nothing is simulated or written.
    Raises InputError for a file or a lock that cannot be read.
    """
    controller = load_controller(path)
    lock = controller.project.lock
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    settings = controller.settings
    if entry is None:
        message = f"{LOCK_NAME} knows of no run of it."
        return KeptRun(controller, settings, (str(controller.path),), None, message)
    recorded = RunInputs.from_data(entry.inputs)
    given = given_options(recorded, controller)
    settings = settings.with_options(given)
    files = _files(controller, entry)
    reasons = stale_reasons(recorded, controller, settings)
    if reasons:
        message = f"The trace of its last run is stale: {'; '.join(reasons)}."
        return KeptRun(controller, settings, files, None, message, has_options=bool(given))
    trace = TraceCache(controller.root).read(recorded.fingerprint, controller.file)
    message = "" if trace is not None else "The trace of its last run is not kept on this machine."
    fingerprint = recorded.fingerprint
    return KeptRun(controller, settings, files, trace, message, fingerprint, bool(given))


def check_kept_trace(kept: KeptRun) -> None:
    """Raise InputError where the kept trace is not the run that the lock describes."""
    trace, controller = kept.trace, kept.controller
    entry = controller.project.lock.controllers.get(lock_key(controller.path, controller.root))
    if trace is None or entry is None:
        return
    verdict, summary = kept_verdict(entry), trace_summary(trace)
    said = {name: entry.trace.get(name) for name in _TOLD}
    shown = {name: summary.get(name) for name in _TOLD}
    said["verdict"], shown["verdict"] = (
        None if one is None else [one.kind, *sorted(reason.code for reason in one.reasons)]
        for one in (verdict, trace.verdict)
    )
    said["visits"], shown["visits"] = (
        {name: function["visits"] for name, function in one.get("functions", {}).items()}
        for one in (entry.trace, summary)
    )
    for name, value in said.items():
        if value != shown[name]:
            raise InputError(
                f"the kept trace of its last run and {LOCK_NAME} differ in the {name}: one of the "
                f"two was changed by hand; `tracerisk run {controller.file}` makes both again",
                Location(LOCK_NAME),
            )


def last_duration_s(path: Path | str) -> float | None:
    """Return how long the visits of the last run lasted together [s, simulated].

    `None` for a controller of which the lock knows no run, and for what cannot be read.
    """
    try:
        controller = load_controller(path)
        lock = controller.project.lock
        functions = lock.controllers[lock_key(controller.path, controller.root)].trace["functions"]
        total = math.fsum(float(function["duration_s"]) for function in functions.values())
    except (InputError, LookupError, TypeError, ValueError, AttributeError):
        return None
    return total if total > 0.0 else None


def _files(controller: Controller, entry: ControllerLock) -> tuple[str, ...]:
    """Return the controller, and its other files that the lock knows to hold blocks."""
    others = sorted(file for file, blocks in entry.blocks.items() if blocks)
    listed = [file for file in others if file != controller.file]
    paths = [controller.path, *(controller.path_of(file) for file in listed)]
    return tuple(str(path) for path in paths if path.is_file())
