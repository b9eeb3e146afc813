"""A selector that waits in virtual time, so that asyncio's own event loop runs on it."""

from __future__ import annotations

import math
import selectors
from collections.abc import Mapping
from typing import Any

from tracerisk.ros.time.busy_wait import POLL_COST
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import NANOSECONDS

_RealSelector = selectors.DefaultSelector


class VirtualSelector(selectors.BaseSelector):
    """Asks a real selector what is ready, and waits for it in virtual time.

    An event loop with nothing to wait for polls with a timeout of zero: a coroutine that yields
    again and again is a busy wait, and ends as one.
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._real = _RealSelector()

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Register a file object; see `selectors.BaseSelector.register`."""
        return self._real.register(fileobj, events, data)

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        """Forget a file object; see `selectors.BaseSelector.unregister`."""
        return self._real.unregister(fileobj)

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Change what a file object is watched for."""
        return self._real.modify(fileobj, events, data)

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        """Return what is ready, after at most `timeout` seconds of virtual time."""
        if self._scheduler.current is None:
            return self._real.select(timeout)
        if timeout is not None and timeout <= 0:
            self._scheduler.count_call(POLL_COST)
            return self._real.select(0)
        # Rounded up: a loop that wakes a nanosecond early finds nothing due and polls again.
        timeout_ns = None if timeout is None else max(1, math.ceil(timeout * NANOSECONDS))
        self._scheduler.wait_until(
            lambda: bool(self._real.select(0)),
            timeout_ns=timeout_ns,
            reason="an event of its loop",
        )
        return self._real.select(0)

    def close(self) -> None:
        """Close the real selector."""
        self._real.close()

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        """Return what is registered."""
        return self._real.get_map()
