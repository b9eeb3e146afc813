"""Run a controller; where it lacks what a draft can give and shows no risk, run it with that.

Nobody has confirmed such a draft: each of its values is a reason of the verdict.
"""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from dataclasses import replace
from difflib import SequenceMatcher
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.common.sandbox.fork_server import several_come
from tracerisk.common.text.bounded import file_text
from tracerisk.common.verdict import INPUT_ASSUMED, MISSION_MISSED, Reason
from tracerisk.config import Settings
from tracerisk.errors import Location
from tracerisk.pipeline.robot.kept_choices import KeptChoices
from tracerisk.pipeline.run.attempts import OF_THE_MACHINE, trace_attempts
from tracerisk.pipeline.run.ended_run import PLAIN, ControllerRun, RunOptions
from tracerisk.pipeline.scenarios.arguments.command_line import reads_arguments
from tracerisk.pipeline.trace.run_files import DraftsNoted
from tracerisk.pipeline.workspace.controller import Controller, from_root
from tracerisk.pipeline.workspace.needs_in_source import may_lack
from tracerisk.trace import DRAFTED, Trace

if TYPE_CHECKING:
    from tracerisk.pipeline.scenarios.entries import Attempt, Entries
    from tracerisk.pipeline.scenarios.rounds import Rounds

_OVER = (
    "the search for values that it lacks is over for its computing: `tracerisk scenario "
    "--search-limit S` searches longer"
)
_OF_NOTHING = re.compile(
    r"NoneType|index out of range|KeyError|empty (sequence|list|deque)|"
    r"AttributeError: '(tuple|list|dict|int|float)'"
)
_CONFIRMED = "of the scenario is assumed"
_TO_CONFIRM = "; delete its mark to confirm it"
# Risk blocks move the lines of a source, and what is reported must not change with them.
_LINE_OF_SOURCE = re.compile(r"(\.py):\d+\b")


def trace_with_draft(
    controller: Controller, settings: Settings, options: RunOptions = PLAIN
) -> Trace:
    """Return what the run of a controller showed, with a drafted scenario if it needs one.

    A run that shows risk and raised nothing is returned as it is. Else, and if the settings say so,
    values are drafted as `tracerisk scenario` does; where no draft helps, or a limit of the machine
    ends a run, the first run's outcome stands.
    """
    began, keep = time.monotonic(), options.keep
    kept = KeptChoices()
    runs: list[ControllerRun] = []
    drafts: DraftsNoted = "without_risk" if settings.draft else "never"

    if settings.draft and may_lack(controller):
        several_come()

    def rounds() -> Rounds:
        # Most runs need none of it.
        from tracerisk.pipeline.scenarios.rounds import Rounds

        left_s = settings.wall_limit_s - (time.monotonic() - began)
        base = None if settings.scenario is None else Path(settings.scenario)
        within = replace(settings, wall_limit_s=left_s)
        return Rounds(
            controller,
            within,
            base,
            options.progress,
            kept,
        )

    noted = replace(options, drafts=drafts, on_run=runs.append)
    trace = trace_attempts(controller, settings, noted, kept)
    if not settings.draft or not _may_need_draft(controller, settings, trace, runs):
        return trace
    search = rounds()
    result = _found(controller, search, search.first(trace, runs), keep)
    if result is not None:
        return result
    # What it lacks first hides a name that it asks for later, which no draft can give.
    cut = [_OVER] if search.cut else []
    wrong = _gone_wrong(search.best)
    message = "; ".join((trace.end.message, *search.supply.mistakes, *wrong, *cut))
    return replace(trace, end=replace(trace.end, message=message))


def _may_need_draft(
    controller: Controller, settings: Settings, trace: Trace, runs: list[ControllerRun]
) -> bool:
    """Return whether a run showed no risk, or raised, for want of what a draft can give."""
    is_whole = trace.is_usable and trace.end.cause != "raised"
    if (is_whole and trace.functions) or trace.end.cause in OF_THE_MACHINE:
        return False
    is_module_missing = any(draft.section == "modules" for run in runs for draft in run.drafts)
    if trace.end.cause == "not_importable" or is_module_missing:
        return is_module_missing
    if trace.end.cause != "raised" and any(
        draft.is_instead for run in runs for draft in run.drafts
    ):
        # It may do nothing for a mode or a switch of its own.
        return True
    if any(run.needs and any(draft.value is not None for draft in run.drafts) for run in runs):
        return True
    if trace.end.cause == "raised" and _OF_NOTHING.search(trace.end.message):
        # It used what a message would have brought.
        published = (draft for run in runs for draft in run.drafts if draft.section == "publish")
        if any(draft.value is not None for draft in published):
            return True
    if settings.args:
        return False
    # Arguments are nothing that it asks its world for: how it ended shows that they lack.
    return trace.end.cause != "raised" or reads_arguments(controller, trace.end)


def _found(controller: Controller, search: Rounds, first: Attempt, keep: Path | None) -> (
    Trace | None
):  # fmt: skip
    """Return the run with the best draft; None where no draft makes it show risk."""
    search.go_on(first)
    best = search.best
    if search.is_cut_short or not best.is_traced or best.trace is None:
        return None
    if best.trace.verdict is None or best.trace.verdict.kind != "partial":
        # A fault that comes after a drafted value says nothing of the controller's own mission.
        return None
    trace = best.trace
    if keep is not None:
        # What is kept is the recording of the run that is reported.
        trace = search.trace(best.entries, RunOptions(keep, is_replayed=True))
    return _with_drafts(controller, search, best.entries, trace)


def _gone_wrong(best: Attempt) -> list[str]:
    """Return in words what went wrong first in the best run with drafted values, if one moved."""
    if not (best.is_traced and best.entries.drafts) or best.trace is None:
        return []
    verdict = best.trace.verdict
    if verdict is None or verdict.kind != "faulted" or not verdict.deciding_reasons:
        return []
    words = verdict.deciding_reasons[0].words
    return [f"with values drafted for what it lacks, it moves and goes wrong: {words}"]


def _with_drafts(controller: Controller, search: Rounds, entries: Entries, trace: Trace) -> Trace:
    """Return a run on a draft, which is not a file, with the places that ask for its values."""
    assert trace.verdict is not None
    places = _Places(controller, search, entries)
    reasons = tuple(map(places.of_reason, trace.verdict.reasons))
    findings = tuple(
        replace(finding, location=places.of(finding.location, is_shown=True))
        for finding in trace.findings
    )
    values = "1 value" if places.drafted == 1 else f"{places.drafted} values"
    line = (
        f"{DRAFTED} {values} that the controller asks its world for, and nobody has confirmed; "
        f"`tracerisk scenario {controller.file} --write` writes a scenario with them to "
        "confirm"
    )
    if search.cut:
        line += f"; {_OVER}"
    root = controller.root.resolve()
    read = {from_root(root, file.resolve()) for file in search.written.read_for(entries)}
    return replace(
        trace,
        verdict=replace(trace.verdict, reasons=reasons),
        findings=findings,
        assumptions=(line, *trace.assumptions),
        inputs=tuple(sorted({*trace.inputs, *read})),
    )


class _Places:
    """Where the lines of a draft are from; `drafted` counts the values already reported."""

    def __init__(self, controller: Controller, search: Rounds, entries: Entries) -> None:
        self._root = controller.root.resolve()
        self._search = search
        self._entries = entries
        self._base = search.supply.base
        self._name = search.draft_name
        self._of_base = _lines_of_base(self._base, search.supply.text(entries))
        self.drafted = 0

    def of(self, place: Location | None, *, is_shown: bool = False) -> Location | None:
        """Return a place in the draft as that in the base, or as that which asks for the value.

        `is_shown`: the base is given by its name alone, as findings do.
        """
        if place is None or Path(place.file).name != self._name or place.line is None:
            return place
        if self._base is not None and place.line in self._of_base:
            name = self._base.name if is_shown else from_root(self._root, self._base.resolve())
            return Location(name, self._of_base[place.line])
        key = self._search.supply.entry_at(self._entries, place.line)
        return None if key is None else self._entries.drafts[key].location

    def of_reason(self, reason: Reason) -> Reason:
        place = reason.location
        if place is None or Path(place.file).name != self._name:
            return reason
        is_unused = reason.code not in (INPUT_ASSUMED, MISSION_MISSED)
        # No line of the source asks for the robot and the arguments.
        is_asked = not reason.object.startswith(("robot", "arguments[")) or is_unused
        at = self.of(place, is_shown=is_unused)
        moved = replace(reason, location=at if is_asked or place.line in self._of_base else None)
        if reason.code != INPUT_ASSUMED or place.line in self._of_base:
            return moved
        self.drafted += 1
        text = reason.words.removesuffix(_TO_CONFIRM).replace(_CONFIRMED, "is drafted", 1)
        text = _LINE_OF_SOURCE.sub(r"\1", text)
        key = self._search.supply.entry_at(self._entries, place.line or 0)
        if key is not None and key[0] == "publish":
            text += f", {_when(self._entries.drafts[key].value)}"
        return replace(moved, words=f"{text}; nobody has confirmed it")


def _when(entry: Mapping[str, Any]) -> str:
    """Return in words when what a drafted entry of `publish` sends comes.

    What comes while nobody waits for it has no effect, and a run goes on without it.
    """
    if "rate" in entry:
        count = entry.get("count")
        return f"{entry['rate']:g} times a second" + (f", {count} times" if count else "")
    if "at" in entry:
        at = entry["at"] if isinstance(entry["at"], list) else [entry["at"]]
        return f"at {', '.join(f'{seconds:g}' for seconds in at)} s"
    after = f"{entry['after']:g} s after" if "after" in entry else "when"
    return f"once, {after} the controller subscribes"


def _lines_of_base(base: Path | None, text: str) -> Mapping[int, int]:
    """Return the lines of a draft that are those of its base, each with its line there."""
    if base is None:
        return {}
    before = file_text(base, encoding="utf-8-sig").splitlines()
    blocks = SequenceMatcher(None, text.splitlines(), before, autojunk=False).get_matching_blocks()
    return {block.a + i + 1: block.b + i + 1 for block in blocks for i in range(block.size)}
