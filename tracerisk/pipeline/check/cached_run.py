"""The run behind a controller's blocks, as it is cached: no simulation is needed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, lock_key
from tracerisk.common.outcome.kept import kept_changes, kept_tolerances, outcome_summary
from tracerisk.common.verdict import INPUT_ASSUMED, MISSION_MISSED
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location
from tracerisk.pipeline.check.check import given_options
from tracerisk.pipeline.check.remedies import as_typed
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.freshness.trace_cache import TraceCache
from tracerisk.pipeline.trace.kept_verdict import kept_verdict
from tracerisk.pipeline.trace.summary import trace_summary
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.trace import Trace

_TOLD = ("robot", "scene", "end")
"""What the lock keeps of a run as it is."""
_WORDS = {  # of what is called otherwise in the lock
    "success": "conditions of `success` that were not met",
    "duration_s": "durations of its visits",
    "elements": "times in use of its elements",
}
_ROUNDED_S = 0.002
"""By how much a time of the lock differs from that of the trace for its rounding [s]."""


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
    if verdict is not None and not verdict.is_bad:
        # The reason of an unmet condition that nobody has confirmed is an assumed input.
        is_named = any(reason.code in (MISSION_MISSED, INPUT_ASSUMED) for reason in verdict.reasons)
        is_missed = any(not condition.is_met for condition in trace.success)
        said["success"], shown["success"] = False, is_missed and not is_named
    for name in ("visits", "duration_s", "elements"):
        said[name], shown[name] = (
            {ref: function.get(name) for ref, function in one.get("functions", {}).items()}
            for one in (entry.trace, summary)
        )
    if trace.end.simulated_s is not None:
        # It cannot be shorter than one of its visits.
        longest_s = max((visit.duration_s or 0.0 for visit in trace.visits), default=0.0)
        said["length"] = max(trace.end.simulated_s, longest_s)
        shown["length"] = trace.end.simulated_s
    outcome = outcome_summary(trace.outcome, kept_tolerances(entry.trace))
    said["outcome"], shown["outcome"] = False, bool(kept_changes(entry.trace, outcome))
    tolerance = kept.settings.tolerance
    for name, value in said.items():
        if not _is_same(value, shown[name], tolerance):
            raise InputError(
                f"the kept trace of its last run and {LOCK_NAME} differ in the "
                f"{_WORDS.get(name, name)}: one of the two was changed by hand; "
                f"`tracerisk run {as_typed(controller.path)}` makes both again",
                Location(LOCK_NAME),
            )


def _is_same(said: Any, shown: Any, tolerance: float) -> bool:
    """Return whether the lock says what the trace shows; it may keep a time of an earlier run."""
    if isinstance(said, Mapping) and isinstance(shown, Mapping):
        names = said.keys() | shown.keys()
        return all(_is_same(said.get(name), shown.get(name), tolerance) for name in names)
    if isinstance(said, float) and isinstance(shown, float):
        return math.isclose(said, shown, rel_tol=tolerance, abs_tol=_ROUNDED_S)
    return bool(said == shown)


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
