"""Find what a controller needs by running it again and again, each time with what it lacked before.

A scenario grows from run to run until nothing is asked for in vain. Where more makes a run worse,
it is left out.
"""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.common.dependencies import require_linux
from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.common.traced.findings import UNUSED
from tracerisk.config import Settings
from tracerisk.errors import DriverError, ScenarioError, TraceRiskError
from tracerisk.pipeline.launch.program import program_of
from tracerisk.pipeline.robot.kept_choices import KeptChoices
from tracerisk.pipeline.run.attempts import OF_THE_MACHINE, trace_attempts
from tracerisk.pipeline.run.companions.find import find_companions
from tracerisk.pipeline.run.ended_run import PLAIN, ControllerRun, RunOptions
from tracerisk.pipeline.scenarios.command_lines import CommandLine, command_lines, reads_arguments
from tracerisk.pipeline.scenarios.entries import (
    Attempt,
    Entries,
    EntryKey,
    ScenarioDraft,
    answered_alone,
    as_streams,
    is_accompanied,
    is_beside,
    is_given,
    merged,
    names_own_joints,
    one_by_one,
    repeated,
    set_down_above,
    useful_drafts,
    without_instead,
    without_one,
    without_repeats,
)
from tracerisk.pipeline.scenarios.text import with_entries
from tracerisk.pipeline.scenarios.written_values import WrittenValues
from tracerisk.pipeline.trace.run_files import IDLE_S
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft
from tracerisk.ros.drafts.drafted_entries import sent_in_turn
from tracerisk.ros.drafts.drafted_parameter import last_part
from tracerisk.ros.drafts.drafting import move_aside, stands_free
from tracerisk.ros.drafts.named_numbers import Reach
from tracerisk.ros.drafts.shifted_poses import shifted
from tracerisk.ros.scenario.file.lines import entry_lines
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.trace import CommandEnd, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.run.ended_run import Progress

_MOST_RUNS = 12
_MOST_DURATIONS = 4  # simulated time of all runs, in that which one may take
_LEAST_WALL_S = 1.0  # what a run may take, however little is left of the wall time of all
_MOST_FRUITLESS = 3  # runs in a row that show nothing which no run before has shown
_IDLE_S = 20.0  # what is drafted comes sooner: for how long a run with it may wait [s]
_MOST_WALLS = 4.0  # wall time of all, in the time that they may compute or sleep
_LEAST_CPU_S = 10.0  # what a run may compute, however little is left of the search
SEARCH_S = 60.0
"""For how long the runs of a search may compute or sleep in all [s]."""
_ASKED_AGAIN = 3  # rounds of answers for a question that comes again
_PUBLISHERS = ("joint_state_publisher_gui", "joint_state_publisher", "joint_state_slider")
_MOST_PLACES = 2  # other poses for what a motion did not reach
_MOST_SHIFTS = 4  # of the poses, by as much as brings the goals made of them within reach
_UNREACHED = frozenset(
    {
        *("planning-failed", "ik-failed", "path-cut"),
        *("command-aborted", "command-ignored", "command-rejected"),
    }
)
_CARRIED_OUT: frozenset[CommandEnd | None] = frozenset(
    {"arrived", "replaced", "left_on", "cut_by_end", "cancelled"}
)
_OF_NODES = frozenset({"services", "actions", "drivers"})
_CONTENT = {"topic": "message", "call": "request", "goal": "goal"}


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
        self.base = base
        self._known = Scenario() if base is None else read_scenario(base)
        self._progress = progress
        self._kept = kept
        root = controller.root.resolve()
        script = controller.path.resolve()
        program = program_of(script, root, controller.workspace)
        self._written = WrittenValues(controller.project.top, program)
        self._usable: dict[EntryKey, Draft] = {}
        self._cannot: dict[EntryKey, Draft] = {}
        self._places = 0
        self._shifts = 0
        self._began = time.monotonic()
        self._wall_limit_s = settings.wall_limit_s
        self._simulated_s = 0.0
        self._read: dict[str, str] = {}
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
        self._left: set[Need] = set()
        self._instead: dict[EntryKey, Draft] = {}
        self._dropped: set[EntryKey] = set()
        self._in_other_units: set[EntryKey] = set()

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

    @property
    def mistakes(self) -> tuple[str, ...]:
        """The names that the source likely has wrong, with what is meant and the place."""
        return tuple(
            f"{draft.need.words} is {draft.words}"
            + (f" ({draft.location})" if draft.location else "")
            for draft in self._cannot.values()
            if draft.need.kind == "frame"
        )

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
            key = self.entry_at(self.best.entries, place.line or 0)
            if finding.object and key is not None:
                entries.drafts.pop(key, None)
        if len(entries.drafts) < len(self.best.entries.drafts):
            attempt = self._run(entries)
            if attempt.score >= self.best.score:
                self.best = attempt

    def _search(self, attempt: Attempt) -> None:
        self._simulated_s = 0.0
        seen, shown, n_fruitless = {self.text(attempt.entries)}, {_shown(attempt)}, 0
        raised = Counter(_raised(attempt))
        for number in range(1, _MOST_RUNS + 1):
            following = (
                entries for entries in self._next(attempt) if self.text(entries) not in seen
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
            seen.add(self.text(more))
            n_fruitless = n_fruitless + 1 if _shown(attempt) in shown else 0
            shown.add(_shown(attempt))
            raised.update(_raised(attempt))
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
        mended = self._mended(attempt)
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
            wanted = self._with_wanted(attempt)
            if wanted is not None:
                yield wanted
            else:
                answered = self._with_answers_alone(attempt)
                if answered is not None:
                    yield answered
        is_worse = before.is_traced and attempt.score < before.score
        if not self._singles and (is_worse or (wanted is None and attempt.has_raised)):
            # Of what was given together, what does no harm alone.
            self._singles = one_by_one(before.entries, attempt.entries)
            self._before = before.entries
        while self._singles:
            ground = self._before if self.best.has_raised else self.best.entries
            yield self._on_top(ground, self._singles.pop(0))
        above = set_down_above(self.best.entries) if self.best.is_faulted else None
        if above is not None:
            yield above
        elsewhere = self._elsewhere(self.best)
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
                self._dropped.add(key)
                yield fewer
        if not self.best.is_traced:
            yield from self._with_other_defaults()
        if not self.best.is_traced and self._may_need_arguments(attempt):
            yield from self._with_arguments()

    def _with_arguments(self) -> Iterator[Entries]:
        """Yield the best entries with each command line that was not tried yet."""
        if self._lines is None:
            written = self._written.arguments
            self._lines = list(command_lines(self._controller, written, self._reach))
        while self._lines:
            entries = self.best.entries.copy()
            entries.arguments = self._lines.pop(0)
            yield entries

    def _with_other_defaults(self) -> Iterator[Entries]:
        """Yield the best entries with one parameter each that is not as its default is."""
        for key, draft in self._instead.items():
            for value in (draft.value, *draft.others):
                entries = without_instead(self.best.entries)
                if key not in entries.drafts:
                    entries.drafts[key] = replace(draft, value=value)
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
            # Where the robot begins was no help, nor was another value than a default.
            entries = without_instead(entries)
            entries.drafts = {k: draft for k, draft in entries.drafts.items() if k[0] != "start"}
        given = tuple(entries.drafts.values())
        missing = tuple(self._cannot.values())
        return ScenarioDraft(
            self.text(entries),
            given,
            missing,
            self.cut,
            entries.arguments,
            best.trace,
            best.error,
        )

    def text(self, entries: Entries) -> str:
        """Return the scenario: the base with these entries."""
        remarks = [f"# {draft.need.words}: {draft.words}" for draft in self._cannot.values()]
        if not remarks and not entries.sections and self.base is None:
            remarks = ["# The controller asks its world for nothing that is not there."]
        return with_entries(self.base, entries.sections, remarks)

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
            path.write_text(self.text(entries), encoding="utf-8", newline="")
            settings = replace(
                self._settings,
                scenario=str(path),
                robot=self._settings.robot or self._known.robot,
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
        if not trace.is_usable:
            # What nodes beside the controller give needs no scenario, unless it shows nothing so.
            had = entries.drafts.keys() | self._cannot.keys()
            beside = next((run for run in reversed(runs) if is_accompanied(run)), chosen)
            chosen = beside if any((e.section, e.key) not in had for e in beside.drafts) else chosen
        drafts = useful_drafts(chosen.drafts, runs)
        for draft in drafts:
            if draft.is_instead and not self._is_set(draft):
                self._instead.setdefault((draft.section, draft.key), draft)
        wanted = tuple(draft for draft in drafts if not draft.is_instead)
        return Attempt(entries, trace, wanted, shift=chosen.shift)

    def _is_set(self, draft: Draft) -> bool:
        """Return whether the user gives a parameter, in the scenario or on the command line."""
        known = {last_part(parameter.name) for parameter in self._known.parameters}
        words = re.findall(r"[^\W_]\w*", " ".join(self._settings.args))
        return bool(self._settings.params) or last_part(draft.key) in known.union(words)

    def _mended(self, attempt: Attempt) -> Entries | None:
        """Return the entries without what kept the controller from being run; None for nothing."""
        error, entries = attempt.error, attempt.entries.copy()
        if isinstance(error, ScenarioError | DriverError) and error.location is not None:
            key = self.entry_at(entries, error.location.line or 0)
            if key is None:
                return None
            if key in self._usable and entries.drafts[key] != self._usable[key]:
                entries.drafts[key] = self._usable[key]
            else:
                self._cannot[key] = replace(
                    entries.drafts.pop(key), value=None, words=f"not given: {error.message}"
                )
            return entries
        return None

    def entry_at(self, entries: Entries, line: int) -> EntryKey | None:
        """Return the entry that stands at a line of the scenario."""
        lines = self.text(entries).splitlines()[:line]
        last: EntryKey | None = None
        for number in range(len(lines), 0, -1):
            for key, draft in entries.drafts.items():
                if lines[number - 1].strip() == entry_lines(draft)[0].strip():
                    last = key
                    break
            if last is not None:
                break
        return last

    def _with_wanted(self, attempt: Attempt) -> Entries | None:
        """Return the entries with what the run lacked; None where there is nothing new."""
        entries = attempt.entries.copy()
        is_new = False
        n_objects = sum(map(stands_free, entries.drafts.values()))
        left: list[Draft] = []
        for draft in attempt.wanted:
            key = draft.section, draft.key
            if key in entries.drafts:
                if draft.section == "drivers" and draft.value != entries.drafts[key].value:
                    # It was asked for numbers too large for its units.
                    is_new |= key not in self._in_other_units
                    self._in_other_units.add(key)
                    entries.drafts[key] = replace(
                        entries.drafts[key], value=draft.value, words=draft.words
                    )
                elif draft.section == "answers" and not attempt.is_traced:
                    entries.repeats[key] = entries.repeats.get(key, 1) + 1
                    is_new |= entries.repeats[key] <= _ASKED_AGAIN
                continue
            if key in self._cannot or key in self._dropped or is_given(self._known, draft):
                continue
            if draft.value is None:
                self._cannot[key] = draft
            elif self._is_left_to_others(draft):
                left.append(draft)
            else:
                if stands_free(draft):
                    # Those of earlier runs stand where this one would.
                    for entry in (draft.value, *draft.others):
                        move_aside(entry, n_objects)
                self._give(entries, draft)
                is_new = True
        if is_beside(attempt):
            # They answer it themselves, as the author means it.
            left.clear()
        if not is_new:
            # The run that lacked it had those nodes beside it.
            for draft in left:
                self._give(entries, draft)
        return entries if is_new or left else None

    def _with_answers_alone(self, attempt: Attempt) -> Entries | None:
        """Return the entries with answers in the place of drafted drivers that moved nothing.

        Where no motion that they were asked for came to its end, they are not what the author's
        own nodes do: that fault is none of the controller's. None where there is nothing to change.
        """
        trace = attempt.trace
        if trace is None or trace.verdict is None or trace.verdict.kind != "faulted":
            return None
        ends = {command.end for command in trace.commands}
        if not ends or ends & _CARRIED_OUT:
            return None
        entries = answered_alone(attempt.entries)
        if entries is not None:
            self._dropped |= attempt.entries.drafts.keys() - entries.drafts.keys()
            self.best = Attempt(entries)
        return entries

    def _give(self, entries: Entries, draft: Draft) -> None:
        key = draft.section, draft.key
        self._usable[key] = draft
        entries.drafts[key] = self._from_repository(draft)

    def _is_left_to_others(self, draft: Draft) -> bool:
        """Return whether a node of the workspace provides it, which may be started for it.

        Only once: what is asked for again, though the node runs beside, is drafted.
        """
        is_theirs = draft.section in _OF_NODES and self._settings.companions
        if not is_theirs or draft.need in self._left:
            return False
        self._left.add(draft.need)
        return bool(find_companions(self._controller, (draft.need,), self._settings))

    def _from_repository(self, draft: Draft) -> Draft:
        """Return the draft with the value that the repository writes, if it does."""
        need = replace(draft.need, name=draft.key) if draft.need.kind == "parameter" else draft.need
        is_one_of_several = draft.key.endswith("]")
        written = None if is_one_of_several else self._written.of(need)
        if written is None:
            return self._as_published(draft)
        value = written.value
        if draft.need.kind == "frame":
            value = {**value, "frame": draft.need.name}
        elif draft.need.kind != "parameter":
            content = _CONTENT[draft.need.kind]
            if not names_own_joints(draft, value):
                return self._as_published(draft)
            if not written.is_whole:
                # The frame of a computed pose is not that of the one which stands in for it.
                value = {key: item for key, item in value.items() if key != "header"}
                if not value or content not in draft.value:
                    return self._as_published(draft)
                value = merged(draft.value[content], value)
            is_stream = "rate" in draft.value and "messages" not in draft.value
            in_turn = [item for item in written.in_turn if names_own_joints(draft, item)]
            if len(in_turn) > 1 and not is_stream:
                value = sent_in_turn(draft.value, in_turn)
            else:
                value = {**draft.value, content: value}
                value.pop("messages", None)
            if "messages" not in value and "messages" in draft.value:
                for key in ("rate", "count", "at"):
                    value.pop(key, None)
        words = f"as in {written.place}"
        self._read[words] = written.place
        return replace(draft, value=value, words=words)

    def _as_published(self, draft: Draft) -> Draft:
        if draft.need.kind != "topic" or draft.need.type_name != "sensor_msgs/JointState":
            return draft
        place = self._written.started_with(draft.need.name, _PUBLISHERS)
        if place is None:
            return draft
        words = f"{draft.words}; as {place} would"
        self._read[words] = place.rpartition(" in ")[2]
        return replace(draft, words=words)

    def _elsewhere(self, best: Attempt) -> Entries | None:
        """Return the entries with other poses, where a motion to those of the best run failed."""
        verdict = None if best.trace is None else best.trace.verdict
        if verdict is None or not any(reason.code in _UNREACHED for reason in verdict.reasons):
            return None
        entries = best.entries.copy()
        if best.shift is not None and self._shifts < _MOST_SHIFTS:
            self._shifts += 1
            # What the repository writes of an entry stays.
            moved = {
                key: self._from_repository(replace(draft, value=shifted(draft.value, *best.shift)))
                for key, draft in entries.drafts.items()
                if key in self._usable
            }
            if any(entries.drafts[key] != draft for key, draft in moved.items()):
                entries.drafts |= moved
                return entries
        if self._places >= _MOST_PLACES:
            return None
        for key, draft in entries.drafts.items():
            usable = self._usable.get(key)
            if usable is None or self._places >= len(usable.others):
                continue
            made = [
                self._from_repository(replace(usable, value=item)).value
                for item in (usable.value, *usable.others)
            ]
            if draft.value in (usable.value, *usable.others):
                other = usable.others[self._places]
            elif draft.value in made:
                other = made[1 + self._places]
            else:
                continue
            entries.drafts[key] = replace(draft, value=other)
        self._places += 1
        return entries

    def _on_top(self, best: Entries, single: Entries) -> Entries:
        entries = best.copy()
        entries.drafts.update(single.drafts)
        return entries

    def read_for(self, entries: Entries) -> tuple[Path, ...]:
        """Return the files of the repository in which values of these entries are written."""
        reported = [draft.words for draft in entries.drafts.values()]
        places = [self._read[words] for words in reported if words in self._read]
        if entries.arguments is not None:
            written = {f"as in {place}": place for _, place in self._written.arguments}
            places += [
                written[remark] for remark in (entries.arguments.remark,) if remark in written
            ]
        top = self._controller.project.top
        return tuple(dict.fromkeys(top / place.rpartition(":")[0] for place in places))

    def _may_need_arguments(self, attempt: Attempt) -> bool:
        has_some = bool(self._settings.args or self._known.arguments)
        return not has_some and attempt.error is None


def _raised(attempt: Attempt) -> Iterator[Hashable]:
    """Yield the exception that ended a run, if one did."""
    if attempt.trace is not None and attempt.has_raised:
        yield attempt.trace.end.message, attempt.trace.end.location


def _shown(attempt: Attempt) -> Hashable:
    """Return what a run showed: how it ended, what it lacked still, what went wrong."""
    trace = attempt.trace
    if trace is None:
        return None if attempt.error is None else attempt.error.message
    reasons = () if trace.verdict is None else trace.verdict.reasons
    lacking = {
        (draft.section, draft.key) for draft in attempt.wanted
    } - attempt.entries.drafts.keys()
    return (
        (trace.end.cause, trace.end.location, attempt.score, frozenset(lacking)),
        frozenset((e.code, e.function, e.object) for e in reasons if e.code != "input-assumed"),
    )
