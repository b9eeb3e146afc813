"""`tracerisk run --watch`: run the controller again whenever a file of it changes."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from tracerisk.cli.running.finished_run import FinishedRun, finish_run
from tracerisk.cli.running.shown import show_failure, show_run
from tracerisk.cli.shared.output import note
from tracerisk.cli.shared.progress import progress_bar
from tracerisk.cli.shared.sources import read_profile
from tracerisk.cli.shared.watching import Watch, note_error, watch
from tracerisk.common.dependencies import require_runs
from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.freshness.watched_files import watched_files
from tracerisk.trace import RunFailedError

if TYPE_CHECKING:
    from tracerisk.pipeline.run.ended_run import Progress

RUNNING = ("starting the twin", "simulating")
"""The phases of the progress in which the controller's own process is at work."""


def watch_run(options: argparse.Namespace) -> NoReturn:
    """Run the controller again and again; ends by an interrupt."""
    require_runs("running a controller")
    several_come()
    path = Path(options.controller)
    read_profile(options)
    last: list[FinishedRun] = []
    files = watched_files(path, None, None, None)

    def update(watched: Watch) -> Iterable[Path]:
        clock = _Clock()
        known = last[-1] if last else None
        with progress_bar(quiet=options.quiet, controller=options.controller) as bar:
            done = finish_run(options, _looking(watched, clock, bar), known)
        if done is known:
            note(f"{path}: nothing that its figure depends on has changed", quiet=options.quiet)
        else:
            note(_followed(done, known, clock), quiet=options.quiet)
            show_run(options, done)
        last[:] = [done]
        assessed = done.assessed
        return {
            *files,
            *watched_files(path, assessed.controller, assessed.trace, assessed.settings),
        }

    def show_error(error: TraceRiskError) -> None:
        if isinstance(error, RunFailedError):
            show_failure(options, error.trace)
        else:
            note_error(error)

    watch(files, update, quiet=options.quiet, show_error=show_error, sources=path.parent)


@dataclass(slots=True)
class _Clock:
    """The times of one update, as a monotonic clock gives them."""

    began: float = field(default_factory=time.monotonic)
    """When the update began [s]."""
    started: float | None = None
    """When the controller's process started to work [s]; `None` while it is not at work."""
    ran_s: float = 0.0
    """The wall time for which it has worked so far [s]."""

    def pass_on(self, phase: str) -> None:
        """Take a phase that begins."""
        now = time.monotonic()
        if phase in RUNNING:
            self.started = self.started or now
        elif self.started is not None:
            self.ran_s += now - self.started
            self.started = None


def _looking(watched: Watch, clock: _Clock, bar: Progress | None) -> Progress:
    """Return what passes on the progress, and ends work on what has changed meanwhile."""

    def phase_text(phase: str, simulated_s: float) -> None:
        watched.look()
        clock.pass_on(phase)
        if bar is not None:
            bar(phase, simulated_s)

    return phase_text


def _followed(done: FinishedRun, known: FinishedRun | None, clock: _Clock) -> str:
    """Return how the figure moved, and how long that took, on one line."""
    wall_s = time.monotonic() - clock.began
    now = done.assessed.assessment.mission.failure_probability
    phase_text = f"mission failure {now:.4g}"
    if known is not None:
        before = known.assessed.assessment.mission.failure_probability
        change = f" ({100.0 * (now / before - 1.0):+.3g} %)" if before > 0.0 else ""
        phase_text += ", as before" if now == before else f", was {before:.4g}{change}"
    is_same = known is not None and done.assessed.trace is known.assessed.trace
    how = f"{wall_s:.2f} s, without a run"
    if not is_same:
        how = f"{wall_s:.2f} s, of which the run {clock.ran_s:.2f} s"
    return f"{phase_text}; {how}"
