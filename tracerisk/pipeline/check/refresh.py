"""Bring a controller's blocks up to date, simulating only where its trace is stale."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tracerisk.adder.lock.lock import LOCK_NAME, ControllerLock, Lock, lock_key
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.owned import MovedUse, moved_uses
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.verdict import Verdict
from tracerisk.config import SANDBOX_SETTINGS, SandboxMode
from tracerisk.errors import BlockError, ControllerFailedError, Location
from tracerisk.pipeline.annotate import Annotated, annotate
from tracerisk.pipeline.check.check import check_controller, given_options
from tracerisk.pipeline.check.remedies import MENDED_BY_REFRESH
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.known_controllers import with_moved
from tracerisk.pipeline.freshness.known_functions import check_blocks
from tracerisk.pipeline.freshness.run_inputs import RunInputs, run_inputs
from tracerisk.pipeline.freshness.trace_cache import TraceCache
from tracerisk.pipeline.scenarios.trace_controller import trace_controller
from tracerisk.pipeline.trace.kept_verdict import kept_verdict, with_refused
from tracerisk.pipeline.trace.summary import is_run_of
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.project import Projects
from tracerisk.trace import Trace

How = Literal["fresh", "recomputed", "simulated", "kept"]
"""Nothing was to do; values were recomputed from a cached trace; the controller was run; it was
run, went wrong, and the blocks of its last good run stay."""


@dataclass(frozen=True, slots=True)
class Refreshed:
    """The result of a refresh; nothing is written yet."""

    how: How
    """Whether nothing was to do, values were recomputed, or the controller was simulated."""
    reason: str
    """Why it was done so, in words."""
    annotated: Annotated | None = None
    """The sources and lock to write; `None` where they are fresh, or stay as they are."""
    verdict: Verdict | None = None
    """The verdict of the run behind the blocks; `None` where none is known."""
    lock: Lock | None = None
    """The lock that remembers a run whose blocks are not written; `None` for all others."""

    unwritten_moved: tuple[MovedUse, ...] = ()
    """Those of `moved` where there is nothing to write."""

    @property
    def moved(self) -> tuple[MovedUse, ...]:
        """The values set by hand for what their function does no more, or not alone."""
        return self.unwritten_moved if self.annotated is None else self.annotated.moved

    @property
    def is_changed(self) -> bool:
        """Whether there is something to write."""
        return self.annotated is not None and self.annotated.is_changed


def refresh_controller(
    path: Path,
    projects: Projects,
    *,
    policy: MergePolicy | None = None,
    sandbox: SandboxMode | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Refreshed:
    """Return what brings the blocks of a controller up to date.

    It is run as it was run last, with the options of then, where its trace is stale or not kept.
    `sandbox` goes before the setting of that name.
    Raises EditInTheWayError where a user edited a computed value and the policy says to stop,
    BlockError where a redundancy is set by hand over units that differ, ControllerFailedError where
    the run fails, and what `run` raises else.
    """
    controller = load_controller(path, projects.of(path))
    check_blocks(controller)
    lock = with_moved(controller.project.lock, controller)
    entry = lock.controllers.get(lock_key(controller.path, controller.root))
    recorded = RunInputs.from_data(entry.inputs) if entry is not None else RunInputs()
    settings = controller.settings
    given = given_options(recorded, controller)
    # A lock may come from anywhere: how a run is contained is not for it to say.
    given = {name: value for name, value in given.items() if name not in SANDBOX_SETTINGS}
    settings = settings.with_options({**given, "sandbox": sandbox})
    cache = TraceCache(controller.root)
    trace: Trace | None = None
    reasons: tuple[str, ...] = ("it was never run",)
    if entry is not None:
        wants_fresh = policy is not None and policy.fresh
        # A published log names no robot: there was no run to judge.
        is_judged = kept_verdict(entry) is not None or entry.trace.get("robot") == ""
        is_settled = entry.is_settled and not wants_fresh and is_judged
        checked = check_controller(path, projects)
        kinds = {finding.kind for finding in checked.findings}
        kept = cache.read(recorded.fingerprint, controller.file)
        is_other = kept is not None and not is_run_of(entry.trace, kept)
        if is_settled and not is_other and not kinds & MENDED_BY_REFRESH:
            for finding in checked.findings:
                if finding.kind == "unequal":
                    raise BlockError(finding.message, finding.location)
            text = "nothing that it depends on has changed"
            left = {finding.subject for finding in checked.findings if finding.kind == "moved"}
            moved = tuple(one for one in moved_uses(entry) if one.path in left)
            return Refreshed("fresh", text, verdict=checked.verdict, unwritten_moved=moved)
        reasons = stale_reasons(recorded, controller, settings)
        if not reasons:
            trace = kept
            reasons = () if trace is not None else ("its trace is not kept here",)
            if is_other:
                trace, reasons = None, (f"the trace kept here is not the one of {LOCK_NAME}",)
            if not is_judged:
                reasons = ("its last run has no verdict",) if trace is None else ()
    how: How = "recomputed" if trace is not None else "simulated"
    if trace is None:
        trace = trace_controller(controller, settings, progress=progress)
        _check_end(trace, str(controller.path))
    text = "; ".join(reasons) or "values recomputed from the cached trace"
    if not (policy is not None and policy.fresh) and _would_lose(entry, trace):
        inputs = run_inputs(controller, trace, settings, given=given).data()
        key = lock_key(controller.path, controller.root)
        assert entry is not None, "blocks that would be lost are of a run"
        remembered = lock.with_controller(key, with_refused(entry, trace.verdict, inputs))
        return Refreshed("kept", text, verdict=trace.verdict, lock=remembered)
    if progress is not None:
        progress("annotating", trace.end.simulated_s or 0.0)
    annotated = annotate(
        controller,
        trace,
        load_hardware(settings, trace.robot),
        settings,
        policy=policy,
        given=given,
    )
    return Refreshed(how, text, annotated, trace.verdict)


def _would_lose(entry: ControllerLock | None, trace: Trace) -> bool:
    """Return whether blocks of a run that went well would give way to those of one that did not.

    A run that went wrong shows less: the blocks of what it did not reach would go.
    """
    before = None if entry is None else kept_verdict(entry)
    is_good = before is not None and not before.is_bad
    return is_good and trace.verdict is not None and trace.verdict.is_bad


def _check_end(trace: Trace, path: str) -> None:
    place = trace.end.location or Location(path, 1)
    if not trace.is_usable:
        raise ControllerFailedError(trace.end.message, place, code=trace.end.code)
    if not trace.functions:
        raise ControllerFailedError(f"{trace.end.message}, and it commanded no hardware", place)
