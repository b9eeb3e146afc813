"""Other poses for the motions to drafted ones that a run did not carry out."""

from __future__ import annotations

from dataclasses import replace

from tracerisk.pipeline.scenarios.entries import Attempt, Entries
from tracerisk.pipeline.scenarios.supply import Supply
from tracerisk.pipeline.scenarios.written_drafts import WrittenDrafts
from tracerisk.ros.drafts.shifted_poses import shifted

_MOST_PLACES = 2  # other poses for what a motion did not reach
_MOST_SHIFTS = 4  # of the poses, by as much as brings the goals made of them within reach
_UNREACHED = frozenset(
    {
        *("planning-failed", "ik-failed", "path-cut"),
        *("command-aborted", "command-ignored", "command-rejected"),
    }
)


class OtherPoses:
    """The poses that a search has tried in the place of those which it drafted first."""

    def __init__(self, supply: Supply, written: WrittenDrafts) -> None:
        self._supply = supply
        self._written = written
        self._places = 0
        self._shifts = 0

    def after(self, best: Attempt) -> Entries | None:
        """Return the entries with other poses, where a motion to those of the best run failed."""
        verdict = None if best.trace is None else best.trace.verdict
        if verdict is None or not any(reason.code in _UNREACHED for reason in verdict.reasons):
            return None
        entries = best.entries.copy()
        if best.shift is not None and self._shifts < _MOST_SHIFTS:
            self._shifts += 1
            # What the repository writes of an entry stays.
            moved = {
                key: self._written.of(replace(draft, value=shifted(draft.value, *best.shift)))
                for key, draft in entries.drafts.items()
                if key in self._supply.usable
            }
            if any(entries.drafts[key] != draft for key, draft in moved.items()):
                entries.drafts |= moved
                return entries
        if self._places >= _MOST_PLACES:
            return None
        for key, draft in entries.drafts.items():
            usable = self._supply.usable.get(key)
            if usable is None or self._places >= len(usable.others):
                continue
            made = [
                self._written.of(replace(usable, value=item)).value
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
