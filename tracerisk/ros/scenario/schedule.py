"""When a scenario acts: its events in simulated time, and whether any is still to come."""

from __future__ import annotations

from collections.abc import Callable

from tracerisk.ros.time.scheduler import Scheduler


class Schedule:
    """The events of one scenario.

    `is_pending` returns whether an event that a run has to wait for is still due, `last_ns` when
    the last such event was [ns].
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._pending = 0
        self.last_ns = 0

    @property
    def now_ns(self) -> int:
        """The simulated time [ns]."""
        return self._scheduler.now_ns

    @property
    def is_pending(self) -> bool:
        """Whether an awaited event is still due."""
        return self._pending > 0

    def at(
        self,
        time_ns: int,
        act: Callable[[], None],
        *,
        awaited: bool = True,
        background: bool = False,
    ) -> None:
        """Act at a time [ns]; where it is not `awaited`, a run may be over before.

        What is of the `background` does not keep a standstill from being one.
        """
        self._pending += awaited

        def event() -> None:
            self._pending -= awaited
            if awaited:
                self.last_ns = self.now_ns
            act()

        self._scheduler.call_at(max(time_ns, self.now_ns), event, background=background)
