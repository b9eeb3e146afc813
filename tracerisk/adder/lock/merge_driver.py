"""The three-way merge of `tracerisk.lock`, controller by controller."""

from __future__ import annotations

from tracerisk.adder.lock.lock import ControllerLock, Lock
from tracerisk.adder.lock.reading import joined_entry


def merge_locks(base: Lock, ours: Lock, theirs: Lock) -> Lock:
    """Return the lock of a merge of two branches.

    An entry that one branch alone changed, added or removed is as that branch has it. One that
    both changed is stale, and holds what either may have written into the sources: the next
    refresh settles it.
    """
    names = sorted({*ours.controllers, *theirs.controllers})
    merged = {
        name: entry
        for name in names
        if (
            entry := _entry(
                base.controllers.get(name), ours.controllers.get(name), theirs.controllers.get(name)
            )
        )
        is not None
    }
    return Lock(merged)


def _entry(
    base: ControllerLock | None, ours: ControllerLock | None, theirs: ControllerLock | None
) -> ControllerLock | None:
    if ours == theirs or theirs == base:
        return ours
    if ours == base:
        return theirs
    if ours is None or theirs is None:
        # One branch removed what the other has changed: nothing is lost by keeping it.
        return ours or theirs
    return joined_entry(ours, theirs)
