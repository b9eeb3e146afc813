"""Pauses of the garbage collector, for work that only builds."""

from __future__ import annotations

import gc

_FEW = 1000
_MANY = 100_000


class collection_paused:  # noqa: N801 - it is called as a function
    """Pause cyclic garbage collection while many objects are made and all of them are kept.

    `objects` is about how many, where that is known before; for few there is no pause.

    Each new generation would look through all of them again: three quarters of the time in a model
    of some thousand gates.
    Very many objects are moved to the oldest generation at once and are scanned only with it.
    """

    def __init__(self, objects: int = _FEW) -> None:
        self._objects = objects

    def __enter__(self) -> None:
        self._was_enabled = self._objects >= _FEW and gc.isenabled()
        if self._was_enabled:
            gc.disable()

    def __exit__(self, *_: object) -> None:
        if self._was_enabled:
            # To count what is frozen takes longer than to look through what a small model has made.
            if gc.get_count()[0] >= _MANY and gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()
            gc.enable()
