"""What the run behind the later version showed that the earlier one did not, by their locks."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from tracerisk.adder.merge.owned import MovedUse, moved_in, moved_uses
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.outcome.changes import OutcomeChanges
from tracerisk.common.outcome.kept import kept_changes, kept_outcome, kept_tolerances
from tracerisk.pipeline.review.controllers import ControllerVersion, ReviewedController
from tracerisk.pipeline.review.renamed_functions import FunctionSource
from tracerisk.pipeline.trace.kept_verdict import kept_verdict
from tracerisk.pipeline.trace.last_run import (
    Touches,
    kept_contacts,
    kept_touches,
    kept_uncovered,
)

if TYPE_CHECKING:
    from tracerisk.common.evidence.cells import Cell, Evidence

_OTHER_DELAY, _OTHER_DELAY_S = 1.5, 0.2
"""A delay is another one that is longer by this share and by so many seconds [s]."""
_QUANTILE = 1.645
_FEW = 10
"""Fewer tries on a side say little, though they differ by more than chance at the 10 % level."""
_COUNTED: Mapping[str, Callable[[Cell], bool]] = {
    "is undetected": lambda cell: cell.is_undetected,
    "is noticed by the controller": lambda cell: cell.noticed_by is not None,
    "ends the mission": lambda cell: cell.fails,
    "is stopped safely": lambda cell: cell.fate == "stopped_safely",
}
"""What a failure does, and whether a cell did it."""


def run_changes(
    before: ControllerVersion, after: ControllerVersion, renamed: Mapping[str, str]
) -> tuple[str, ...]:
    """Return in words which contacts and motions without risk data are new.

    `renamed` gives the later name of functions by their earlier one. Nothing is returned where the
    later version has no lock; without an earlier lock all of the later one is new.
    """
    if after.entry is None:
        return ()
    old = {} if before.entry is None else before.entry.trace
    return tuple(_new(old, after.entry.trace, renamed))


def newly_moved(
    controller: ReviewedController, functions: Mapping[str, FunctionSource]
) -> tuple[MovedUse, ...]:
    """Return the values set by hand that only in the later version are not for what is done there.

    `functions` are those of the later version.
    """
    before, after = controller.before, controller.after
    if after.entry is None or not after.entry.owned:
        return ()
    blocks = {
        FunctionRef(os.path.relpath(one.file, after.folder), QualifiedName(one.name)): one.block
        for one in functions.values()
    }
    known = {(one.path, one.took) for one in moved_uses(before.entry)} if before.entry else set()
    moved = (one for one, _ in moved_in(after.entry, blocks))
    return tuple(one for one in moved if (one.path, one.took) not in known)


def evidence_changes(before: ControllerVersion, after: ControllerVersion) -> tuple[str, ...]:
    """Return in words what failures do otherwise by the evidence of both, and whose was edited."""
    if after.entry is None:
        return ()
    texts = []
    for name, evidence in (("before", before.evidence), ("now", after.evidence)):
        if evidence is not None and evidence.edited is not None:
            texts.append(f"the evidence was edited ({name}): {evidence.edited.words}")
    if before.evidence is not None and after.evidence is not None:
        texts += _of_modes(before.evidence, after.evidence)
    return tuple(texts)


def _of_modes(before: Evidence, after: Evidence) -> Iterator[str]:
    """Yield the failures that are now reported sooner or later, or that end otherwise."""
    counted = dict(_COUNTED)
    if not (before.has_fates and after.has_fates):
        # Of an earlier version's cells nobody knows what the controller did.
        counted = {"ends the mission": counted["ends the mission"]}
    old, new = _by_mode(before), _by_mode(after)
    for key in sorted(old.keys() & new.keys()):
        was, now = old[key], new[key]
        what = f"a failure of {key[0]} ({key[1].replace('_', ' ')})"
        notified = _notified_after(was), _notified_after(now)
        if notified[0] != notified[1] and _is_other_delay(*notified):
            verb, earlier = (
                _rarely(cells) if after_s is None else f"after {after_s:.1f} s"
                for cells, after_s in ((now, notified[1]), (was, notified[0]))
            )
            yield f"{what} is now reported {verb}, before: {earlier}"
        counts = [
            f"{verb} in {_count(now, is_so)} of {len(now)} tries, "
            f"before: {_count(was, is_so)} of {len(was)}"
            for verb, is_so in counted.items()
            if _differ(was, now, is_so)
        ]
        if counts:
            few = "; with so few tries it may be chance" if min(len(was), len(now)) < _FEW else ""
            yield f"{what} now {'; '.join(counts)}{few}"


def _by_mode(found: Evidence) -> dict[tuple[str, str], list[Cell]]:
    cells: dict[tuple[str, str], list[Cell]] = {}
    for cell in found.cells:
        cells.setdefault((cell.component, cell.mode), []).append(cell)
    return cells


def _count(cells: Sequence[Cell], is_so: Callable[[Cell], bool]) -> int:
    return sum(1 for cell in cells if is_so(cell))


def _notified_after(cells: Sequence[Cell]) -> float | None:
    """Return the median time until the controller was notified [s]; `None` if it mostly was not."""
    notified = [cell.told_after_s for cell in cells if cell.told_after_s is not None]
    if 2 * len(notified) <= len(cells):
        return None
    from statistics import median  # with random numbers

    return median(notified)


def _rarely(cells: Sequence[Cell]) -> str:
    """Return how often a failure is reported that mostly is not."""
    notified = sum(1 for cell in cells if cell.told_after_s is not None)
    if notified or any(cell.followed_s is not None for cell in cells):
        return f"in {notified} of {len(cells)} tries"
    return "never"


def _is_other_delay(before: float | None, after: float | None) -> bool:
    if before is None or after is None:
        return True
    return max(before, after) > _OTHER_DELAY * min(before, after) + _OTHER_DELAY_S


def _differ(before: Sequence[Cell], after: Sequence[Cell], is_so: Callable[[Cell], bool]) -> bool:
    """Return whether two shares differ by more than chance, at the 10 % level of the z test."""
    n, m = len(before), len(after)
    counts = _count(before, is_so), _count(after, is_so)
    share = sum(counts) / (n + m)
    spread = math.sqrt(share * (1.0 - share) * (1.0 / n + 1.0 / m))
    return abs(counts[0] / n - counts[1] / m) > _QUANTILE * spread > 0.0


def _by_bodies(summary: Mapping[str, object]) -> dict[str, Touches]:
    """Return all unexpected touches of each two bodies, whichever function they were in."""
    touches: dict[str, list[Touches]] = {}
    for contact in kept_contacts(summary):
        if contact.touches is not None:
            touches.setdefault(contact.bodies, []).append(contact.touches)
    return {bodies: Touches.joined(parts) for bodies, parts in touches.items()}


def _new(
    old: Mapping[str, object], new: Mapping[str, object], renamed: Mapping[str, str]
) -> Iterator[str]:
    known = {
        (renamed.get(contact.function.name, contact.function.name), contact.bodies)
        for contact in kept_contacts(old)
    }
    earlier_name = {now: was for was, now in renamed.items()}
    of_before, of_now = _by_bodies(old), _by_bodies(new)
    for contact in kept_contacts(new):
        name, bodies = contact.function.name, contact.bodies
        if (name, bodies) in known:
            continue
        was, part = of_before.get(bodies), contact.touches
        if was is not None and part is not None and of_now[bodies].are_cut_otherwise(was, part):
            continue
        earlier = FunctionRef(contact.function.file, QualifiedName(earlier_name.get(name, name)))
        before, _ = kept_touches(old, replace(contact, function=earlier))
        now, _ = kept_touches(new, contact)
        if before is None or now is None or not now.are_of_grasp_as(before):
            yield f"{contact.bodies} touch in {name}, which was not to be expected{contact.how}"
    uncovered = {
        renamed.get(function_ref.name, function_ref.name) for function_ref in kept_uncovered(old)
    }
    for ref in kept_uncovered(new):
        if ref.name not in uncovered:
            yield f"{ref.name} can move the arm and did not run: no risk data"


def outcome_changes(controller: ReviewedController, in_both: bool) -> OutcomeChanges | None:
    """Return how the outcomes of two versions differ; `None` where a lock keeps none."""
    before, after = controller.before.entry, controller.after.entry
    if not in_both or before is None or after is None:
        return None
    return kept_changes(before.trace, after.trace)


def not_asked(controller: ReviewedController, outcome: OutcomeChanges | None) -> tuple[str, ...]:
    """Return which objects the mission newly moves and a declared `success` does not name."""
    success = controller.after.success
    if not success or outcome is None:
        return ()
    parts = [part for condition in success for part in (condition, *condition.steps)]
    named = {part.name for part in parts if part.kind == "object"}
    return tuple(name for name in outcome.newly_moved if name not in named)


def outcome_gaps(controller: ReviewedController) -> Iterator[str]:
    """Yield what keeps two outcomes from being compared, or by what they are."""
    entries = [
        controller_version.entry for controller_version in (controller.before, controller.after)
    ]
    if any(entry is None or kept_verdict(entry) is None for entry in entries):
        return
    traces = [entry.trace for entry in entries if entry is not None]
    for name, trace in zip(("earlier", "later"), traces, strict=True):
        if kept_outcome(trace) is None:
            yield f"what the {name} run brought about is not known: its lock does not say"
    if kept_tolerances(traces[0]) != kept_tolerances(traces[1]):
        yield "their locks hold different tolerances of the outcome: the smaller ones count"
