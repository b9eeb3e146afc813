"""Kernel events: what is due when, apart from the controller's threads."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(slots=True, order=True)
class ScheduledCall:
    """A kernel event, ordered by time and sequence."""

    time_ns: int
    """The simulated time at which it is due [ns]."""
    sequence: int
    """Its rank among events of the same instant."""
    callback: Callable[[], None] | None = field(compare=False)
    """The function to call; `None` once it is cancelled."""
    background: bool = field(compare=False)
    """Whether the event by itself does not keep a run from standing still."""

    def cancel(self) -> None:
        """Do not run the callback; nothing happens where it has run already."""
        self.callback = None


class EventQueue:
    """Events in the order of their time [ns], and of their sequence within an instant."""

    def __init__(self) -> None:
        self._calls: list[ScheduledCall] = []

    def add(self, call: ScheduledCall) -> ScheduledCall:
        """Add an event."""
        heapq.heappush(self._calls, call)
        return call

    def pop_due(self, now_ns: int) -> Callable[[], None] | None:
        """Take out the first event that is due and return what it calls, or None."""
        self._drop_cancelled()
        if self._calls and self._calls[0].time_ns <= now_ns:
            return heapq.heappop(self._calls).callback
        return None

    @property
    def next_ns(self) -> int | None:
        """The time of the first event [ns], if there is one."""
        self._drop_cancelled()
        return self._calls[0].time_ns if self._calls else None

    @property
    def is_expecting(self) -> bool:
        """Whether there is an event that is not of the background."""
        return any(call.callback is not None and not call.background for call in self._calls)

    def _drop_cancelled(self) -> None:
        while self._calls and self._calls[0].callback is None:
            heapq.heappop(self._calls)
