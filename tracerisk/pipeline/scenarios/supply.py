"""What a search gives a controller for what its runs lacked, and the scenario with that."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from tracerisk.config import Settings
from tracerisk.errors import DriverError, ScenarioError
from tracerisk.pipeline.run.companions.find import find_companions
from tracerisk.pipeline.scenarios.entries import (
    Attempt,
    Entries,
    EntryKey,
    answered_alone,
    is_beside,
    is_given,
    without_instead,
)
from tracerisk.pipeline.scenarios.text import with_entries
from tracerisk.pipeline.scenarios.written_drafts import WrittenDrafts
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.controller.needs import Need, last_part
from tracerisk.ros.drafts.draft import Draft
from tracerisk.ros.drafts.drafting import move_aside, stands_free
from tracerisk.ros.scenario.file.lines import entry_lines
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.trace import CommandEnd

_ASKED_AGAIN = 3  # rounds of answers for a question that comes again
_CARRIED_OUT: frozenset[CommandEnd | None] = frozenset(
    {"arrived", "replaced", "left_on", "cut_by_end", "cancelled"}
)
_OF_NODES = frozenset({"services", "actions", "drivers"})


class Supply:
    """What the runs of a search lacked: the drafts that are given for it, and what cannot be."""

    def __init__(
        self, controller: Controller, settings: Settings, base: Path | None, written: WrittenDrafts
    ) -> None:
        """`base` is the scenario that the user gives; None for none."""
        self.base = base
        self.known = Scenario() if base is None else read_scenario(base)
        self.usable: dict[EntryKey, Draft] = {}
        """What was drafted, before the repository's own values are put in."""
        self.cannot: dict[EntryKey, Draft] = {}
        """What no scenario can give."""
        self.dropped: set[EntryKey] = set()
        """What a run does better without."""
        self._controller = controller
        self._settings = settings
        self._written = written
        self.instead: dict[EntryKey, Draft] = {}
        """Parameters that may have another value than their default."""
        self._left: set[Need] = set()
        self._in_other_units: set[EntryKey] = set()

    @property
    def mistakes(self) -> tuple[str, ...]:
        """The names that the source likely has wrong, with what is meant and the place."""
        return tuple(
            f"{draft.need.words} is {draft.words}"
            + (f" ({draft.location})" if draft.location else "")
            for draft in self.cannot.values()
            if draft.need.kind == "frame"
        )

    def text(self, entries: Entries) -> str:
        """Return the scenario: the base with these entries."""
        remarks = [f"# {draft.need.words}: {draft.words}" for draft in self.cannot.values()]
        if not remarks and not entries.sections and self.base is None:
            remarks = ["# The controller asks its world for nothing that is not there."]
        return with_entries(self.base, entries.sections, remarks)

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

    def mended(self, attempt: Attempt) -> Entries | None:
        """Return the entries without what kept the controller from being run; None for nothing."""
        error, entries = attempt.error, attempt.entries.copy()
        if isinstance(error, ScenarioError | DriverError) and error.location is not None:
            key = self.entry_at(entries, error.location.line or 0)
            if key is None:
                return None
            if key in self.usable and entries.drafts[key] != self.usable[key]:
                entries.drafts[key] = self.usable[key]
            else:
                self.cannot[key] = replace(
                    entries.drafts.pop(key), value=None, words=f"not given: {error.message}"
                )
            return entries
        return None

    def with_wanted(self, attempt: Attempt) -> Entries | None:
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
            if key in self.cannot or key in self.dropped or is_given(self.known, draft):
                continue
            if draft.value is None:
                self.cannot[key] = draft
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

    def with_answers_alone(self, attempt: Attempt) -> Entries | None:
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
            self.dropped |= attempt.entries.drafts.keys() - entries.drafts.keys()
        return entries

    def _give(self, entries: Entries, draft: Draft) -> None:
        key = draft.section, draft.key
        self.usable[key] = draft
        entries.drafts[key] = self._written.of(draft)

    def _is_left_to_others(self, draft: Draft) -> bool:
        """Return whether a node of the workspace provides it, which may be started for it.

        Only once: if the controller lacks it again with that node beside it, it is drafted.
        """
        is_theirs = draft.section in _OF_NODES and self._settings.companions
        if not is_theirs or draft.need in self._left:
            return False
        self._left.add(draft.need)
        return bool(find_companions(self._controller, (draft.need,), self._settings))

    def note_defaults(self, drafts: Iterable[Draft]) -> None:
        """Note which parameters may have another value, where the user gives none."""
        for draft in drafts:
            if draft.is_instead and not self._is_set(draft):
                self.instead.setdefault((draft.section, draft.key), draft)

    def _is_set(self, draft: Draft) -> bool:
        """Return whether the user gives a parameter, in the scenario or on the command line."""
        known = {last_part(parameter.name) for parameter in self.known.parameters}
        words = re.findall(r"[^\W_]\w*", " ".join(self._settings.args))
        return bool(self._settings.params) or last_part(draft.key) in known.union(words)

    def with_other_defaults(self, best: Entries) -> Iterator[Entries]:
        """Yield the entries with one parameter each that is not as its default is."""
        for key, draft in self.instead.items():
            for value in (draft.value, *draft.others):
                entries = without_instead(best)
                if key not in entries.drafts:
                    entries.drafts[key] = replace(draft, value=value)
                    yield entries
