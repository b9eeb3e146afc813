"""Find what a controller needs by running it again and again, each time with what it lacked before.

A scenario grows from run to run until nothing is asked for in vain. Where more makes a run worse,
it is left out.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from tracerisk.common.dependencies import require_linux
from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.common.traced.findings import UNUSED
from tracerisk.config import Settings
from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.robot.kept_choices import KeptChoices
from tracerisk.pipeline.run.attempts import OF_THE_MACHINE, trace_attempts
from tracerisk.pipeline.run.ended_run import PLAIN, ControllerRun, Progress, RunOptions
from tracerisk.pipeline.scenarios.arguments.command_line import CommandLine, reads_arguments
from tracerisk.pipeline.scenarios.arguments.command_lines import command_lines
from tracerisk.pipeline.scenarios.entries import (
    Attempt,
    Entries,
    ScenarioDraft,
    as_streams,
    is_accompanied,
    on_top,
    one_by_one,
    repeated,
    set_down_above,
    useful_drafts,
    without_instead,
    without_one,
    without_repeats,
)
from tracerisk.pipeline.scenarios.other_poses import OtherPoses
from tracerisk.pipeline.scenarios.supply import Supply
from tracerisk.pipeline.scenarios.written_drafts import WrittenDrafts
from tracerisk.pipeline.trace.run_files import IDLE_S
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.drafts.named_numbers import Reach
from tracerisk.trace import Trace

_MOST_RUNS = 12
_MOST_DURATIONS = 4  # simulated time of all runs, in that which one may take
_LEAST_WALL_S = 1.0  # what a run may take, however little is left of the wall time of all
_MOST_FRUITLESS = 3  # runs in a row that show nothing which no run before has shown
_IDLE_S = 20.0  # what is drafted comes sooner: for how long a run with it may wait [s]
_MOST_WALLS = 4.0  # wall time of all, in the time that they may compute or sleep
_LEAST_CPU_S = 10.0  # what a run may compute, however little is left of the search
_NO_HELP = ("start", "mount")  # sections that are left out where nothing moved
SEARCH_S = 60.0
"""For how long the runs of a search may compute or sleep in all [s]."""


def draft_scenario(
    controller: Controller,
    settings: Settings,
    base: Path | None,
    *,
    progress: Progress | None = None,
    own_s: float = SEARCH_S,
) -> ScenarioDraft:
    """Return a scenario with which the controller runs: `base`, and what that does not give.

    The search ends once its runs have computed or slept for `own_s` [s], and by an interrupt, with
    the best so far: a busy machine does not end it earlier.
    Raises ScenarioError where the base is malformed. What else keeps the controller from running
    is in the result.
    """
    require_linux("running a controller")
    several_come()
    return Rounds(controller, settings, base, progress, KeptChoices(), own_s).result()


class Rounds:
    """The runs of a search for a scenario; `best` is what it has come to so far.

    All of them together have the wall time that the settings give to a run. `kept` is what was
    chosen of the workspace.
    """

    draft_name = "drafted.scenario.yaml"  # gone after each run

    def __init__(
        self,
        controller: Controller,
        settings: Settings,
        base: Path | None,
        progress: Progress | None,
        kept: KeptChoices,
        own_s: float = SEARCH_S,
    ) -> None:
        """`own_s` is for how long its runs may compute or sleep in all [s]."""
        self._most_s = _MOST_DURATIONS * settings.run_duration_s
        self._controller = controller
        self._settings = settings
        self._progress = progress
        self._kept = kept
        self.written = WrittenDrafts(controller)
        self.supply = Supply(controller, settings, base, self.written)
        self._other_poses = OtherPoses(self.supply, self.written)
        self._began = time.monotonic()
        self._wall_limit_s = settings.wall_limit_s
        self._simulated_s = 0.0
        self.best = Attempt(Entries())
        self.is_cut_short = False
        self._own_s = own_s
        self._used_s = 0.0
        self._running = Entries()
        self.cut = ""
        self._singles: list[Entries] = []
        self._before = Entries()
        self._lines: list[CommandLine] | None = None
        self._reach: Reach | None = None

    def result(self) -> ScenarioDraft:
        """Run until nothing is lacking, or nothing helps.

        A run that lasts as its simulated time does, for a library of the controller waits, ends
        with the wall time of the search.
        """
        self._wall_limit_s = min(self._wall_limit_s, _MOST_WALLS * max(self._own_s, _LEAST_CPU_S))
        try:
            self.go_on(self._run(Entries()))
        except KeyboardInterrupt:
            self._end_early("the search was interrupted")
        return self._draft(self.best)

    def _is_over(self) -> bool:
        """Return whether the runs have taken the time of the search."""
        return self._used_s >= self._own_s

    def _end_early(self, words: str) -> None:
        self.cut = words
        self.is_cut_short = True
        if not self.best.is_traced:
            # What was found for the last run, though nobody knows yet how that ends.
            self.best = Attempt(self._running)

    def go_on(self, attempt: Attempt) -> None:
        """Run again after a first run, until nothing is lacking, or nothing helps.

        The number of these runs and their simulated time bound it.
        """
        self._search(attempt)
        if self.best.is_traced and not self.is_cut_short and not self._is_over():
            self._leave_out_unused()

    def _leave_out_unused(self) -> None:
        """Leave out of the best scenario what its run made no use of, unless that makes it worse.

        A run that came to its end shows what it uses; one that was stuck might have come there.
        """
        entries, trace = self.best.entries.copy(), self.best.trace
        assert trace is not None
        for finding in trace.findings:
            place = finding.location
            if finding.kind != UNUSED or place is None or place.file != self.draft_name:
                continue
            key = self.supply.entry_at(self.best.entries, place.line or 0)
            if finding.object and key is not None:
                entries.drafts.pop(key, None)
        if len(entries.drafts) < len(self.best.entries.drafts):
            attempt = self._run(entries)
            if attempt.score >= self.best.score:
                self.best = attempt

    def _search(self, attempt: Attempt) -> None:
        self._simulated_s = 0.0
        seen, shown, n_fruitless = {self.supply.text(attempt.entries)}, {attempt.shown}, 0
        raised = Counter(attempt.raised)
        for number in range(1, _MOST_RUNS + 1):
            following = (
                entries for entries in self._next(attempt) if self.supply.text(entries) not in seen
            )
            more = next(following, None)
            if more is None or number == _MOST_RUNS or self._simulated_s >= self._most_s:
                break
            is_last = self._is_over()
            if is_last:
                self._end_at_limit()
                if self.best.is_traced:
                    break
            self._running = more
            attempt = self._run(more)
            if is_last:
                # What nobody has run is not reported: this is how the run with it ends.
                self.best = attempt
                break
            seen.add(self.supply.text(more))
            n_fruitless = n_fruitless + 1 if attempt.shown in shown else 0
            shown.add(attempt.shown)
            raised.update(attempt.raised)
            if n_fruitless == _MOST_FRUITLESS or max(raised.values(), default=0) > _MOST_FRUITLESS:
                break

    def _end_at_limit(self) -> None:
        self.cut = f"the search was ended after {self._own_s:g} s (--search-limit)"

    def _next(self, attempt: Attempt) -> Iterator[Entries]:
        """Yield what may be tried after a run, the likeliest first."""
        if attempt.trace is not None and attempt.trace.end.cause in OF_THE_MACHINE:
            # Nothing is concluded from it, and no other run begins.
            if self._is_over():
                self._end_at_limit()
            else:
                self.is_cut_short = True
                is_own = self._wall_limit_s < self._settings.wall_limit_s
                if is_own and attempt.trace.end.cause == "wall_limit":
                    self.cut = f"the search was ended after {self._wall_limit_s:g} s of wall time"
            if not self.best.is_traced:
                self.best = attempt
            return
        mended = self.supply.mended(attempt)
        if mended is not None:
            yield mended
            return
        before, wanted = self.best, None
        if self._ends_for_arguments(attempt):
            self.best = max(before, attempt, key=lambda item: item.score)
            # Without them it comes to nothing else.
            yield from self._with_arguments()
        if attempt.score >= before.score:
            self.best = attempt
            wanted = self.supply.with_wanted(attempt)
            if wanted is not None:
                yield wanted
            else:
                answered = self.supply.with_answers_alone(attempt)
                if answered is not None:
                    self.best = Attempt(answered)
                    yield answered
        is_worse = before.is_traced and attempt.score < before.score
        if not self._singles and (is_worse or (wanted is None and attempt.has_raised)):
            # Of what was given together, what does no harm alone.
            self._singles = one_by_one(before.entries, attempt.entries)
            self._before = before.entries
        while self._singles:
            ground = self._before if self.best.has_raised else self.best.entries
            yield on_top(ground, self._singles.pop(0))
        above = set_down_above(self.best.entries) if self.best.is_faulted else None
        if above is not None:
            yield above
        elsewhere = self._other_poses.after(self.best)
        if elsewhere is not None:
            yield elsewhere
        if self.best.is_faulted or not self.best.is_traced:
            again = repeated(self.best.entries)
            if again is not None:
                yield again
        if not self.best.is_traced:
            streamed = as_streams(self.best.entries)
            if streamed is not None:
                yield streamed
        if self.best.is_faulted:
            yield without_repeats(self.best.entries)
        if self.best.has_raised:
            for key, fewer in without_one(self.best.entries):
                self.supply.dropped.add(key)
                yield fewer
        if not self.best.is_traced:
            yield from self.supply.with_other_defaults(self.best.entries)
        if not self.best.is_traced and self._may_need_arguments(attempt):
            yield from self._with_arguments()

    def _with_arguments(self) -> Iterator[Entries]:
        """Yield the best entries with each command line that was not tried yet."""
        if self._lines is None:
            written = self.written.arguments
            self._lines = list(command_lines(self._controller, written, self._reach))
        while self._lines:
            entries = self.best.entries.copy()
            entries.arguments = self._lines.pop(0)
            yield entries

    def _ends_for_arguments(self, attempt: Attempt) -> bool:
        """Return whether a run ended where the source reads its command line, and has none."""
        trace = attempt.trace
        if trace is None or attempt.entries.arguments or not self._may_need_arguments(attempt):
            return False
        return reads_arguments(self._controller, trace.end)

    def _draft(self, best: Attempt) -> ScenarioDraft:
        entries = best.entries.copy()
        if not best.is_traced:
            # Where the robot begins or stands was no help, nor was another value than a default.
            entries = without_instead(entries)
            entries.drafts = {
                k: draft for k, draft in entries.drafts.items() if k[0] not in _NO_HELP
            }
        given = tuple(entries.drafts.values())
        missing = tuple(self.supply.cannot.values())
        return ScenarioDraft(
            self.supply.text(entries),
            given,
            missing,
            self.cut,
            entries.arguments,
            best.trace,
            best.error,
        )

    def _run(self, entries: Entries) -> Attempt:
        runs: list[ControllerRun] = []
        try:
            trace = self.trace(entries, RunOptions(on_run=runs.append, is_replayed=True))
        except TraceRiskError as error:
            return Attempt(entries, error=error)
        return self.attempt(entries, trace, runs)

    def trace(self, entries: Entries, options: RunOptions = PLAIN) -> Trace:
        """Run the controller with these entries; raise what keeps it from running."""
        wall_s = self._wall_limit_s - (time.monotonic() - self._began)
        with scratch() as folder:
            # Files that the base names stand in its own folder.
            path = folder / self.draft_name
            path.write_text(self.supply.text(entries), encoding="utf-8", newline="")
            settings = replace(
                self._settings,
                scenario=str(path),
                robot=self._settings.robot or self.supply.known.robot,
                wall_limit_s=max(wall_s, _LEAST_WALL_S),
                cpu_limit_s=min(
                    self._settings.cpu_limit_s, max(self._own_s - self._used_s, _LEAST_CPU_S)
                ),
            )
            idle_s = _IDLE_S if entries.drafts else IDLE_S
            noted = replace(options, progress=self._progress, drafts="always", idle_s=idle_s)
            return trace_attempts(self._controller, settings, noted, self._kept)

    def first(self, trace: Trace, runs: Sequence[ControllerRun]) -> Attempt:
        """Return what the runs before the search came to; the first of them is none of it."""
        attempt = self.attempt(self.best.entries, trace, runs)
        self._used_s -= runs[0].start_s + runs[0].own_s
        return attempt

    def attempt(self, entries: Entries, trace: Trace, runs: Sequence[ControllerRun]) -> Attempt:
        """Return what runs with these entries came to, of which `trace` is the one that counts."""
        self._reach = next((run.reach for run in runs if run.reach), self._reach)
        self._simulated_s += sum(run.trace.end.simulated_s or 0.0 for run in runs)
        self._used_s += sum(run.start_s + run.own_s for run in runs)
        chosen = next((run for run in runs if run.trace is trace), runs[-1])
        if not Attempt(entries, trace).is_traced:
            # What nodes beside the controller give needs no scenario, unless it shows nothing so.
            had = entries.drafts.keys() | self.supply.cannot.keys()
            beside = next((run for run in reversed(runs) if is_accompanied(run)), chosen)
            chosen = beside if any((e.section, e.key) not in had for e in beside.drafts) else chosen
        drafts = useful_drafts(chosen.drafts, runs)
        self.supply.note_defaults(drafts)
        wanted = tuple(draft for draft in drafts if not draft.is_instead)
        return Attempt(entries, trace, wanted, shift=chosen.shift)

    def _may_need_arguments(self, attempt: Attempt) -> bool:
        has_some = bool(self._settings.args or self.supply.known.arguments)
        return not has_some and attempt.error is None
