"""Pauses of the garbage collector, for work that only builds."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

_FEW = 1000


@contextmanager
def collection_paused(objects: int = _FEW) -> Iterator[None]:
    """Pause cyclic garbage collection while many objects are made and all of them are kept.

    `objects` is about how many, where that is known before; for few there is no pause.

    Each new generation would look through all of them again: three quarters of the time in a model
    of some thousand gates.
    They are then old at once, and looked through when all that is old is.
    """
    if objects < _FEW:
        yield
        return
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            if gc.get_freeze_count() == 0:
                gc.freeze()
                gc.unfreeze()
            gc.enable()
