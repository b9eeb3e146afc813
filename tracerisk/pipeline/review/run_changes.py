"""What the run behind the later version showed that the earlier one did not, by their locks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tracerisk.pipeline.review.controllers import ControllerVersion
from tracerisk.pipeline.trace.last_run import kept_contacts, kept_uncovered


def run_changes(
    before: ControllerVersion, after: ControllerVersion, renamed: Mapping[str, str]
) -> tuple[str, ...]:
    """Return in words which contacts and motions without risk data are new.

    `renamed` gives the later name of functions by their earlier one. Nothing is told where the
    later version has no lock; without an earlier lock all of the later one is new.
    """
    if after.entry is None:
        return ()
    old = {} if before.entry is None else before.entry.trace
    return tuple(_new(old, after.entry.trace, renamed))


def _new(
    old: Mapping[str, object], new: Mapping[str, object], renamed: Mapping[str, str]
) -> Iterator[str]:
    touched = {
        (renamed.get(each.function.name, each.function.name), each.bodies)
        for each in kept_contacts(old)
    }
    for contact in kept_contacts(new):
        if (contact.function.name, contact.bodies) not in touched:
            yield f"{contact.bodies} touch in {contact.function.name}, which was not to be expected"
    uncovered = {renamed.get(each.name, each.name) for each in kept_uncovered(old)}
    for ref in kept_uncovered(new):
        if ref.name not in uncovered:
            yield f"{ref.name} can move the arm and did not run: no risk data"
