"""How fast a loop publishes that neither sleeps nor waits: as its publisher would.

Such a loop runs as fast as the machine lets it, a real publisher and whoever listens do not: what
is sent more often than a driver looks takes the place of what was sent before. So a publication
that goes on and on without a wait of its thread in between takes the time of a driver's cycle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tracerisk.ros.controller.thread import ControllerThread
    from tracerisk.ros.time.scheduler import Scheduler

PERIOD_NS = 10_000_000
"""The time from one message of a busy loop to the next [ns]."""
BURST = 50
"""How many messages in a row are no loop yet: a list of poses is sent at once."""
_AT_ONCE_NS = 5_000_000  # later than this, the loop looks at the clock to keep a rate of its own


class PublishingPace:
    """The pace of one publication."""

    __slots__ = ("_in_row", "_last_ns", "_thread", "_waits")

    def __init__(self) -> None:
        self._thread: ControllerThread | None = None
        self._waits = 0
        self._last_ns = 0
        self._in_row = 0

    @property
    def is_of_loop(self) -> bool:
        """Whether the last message was one of a loop that does not wait."""
        return self._in_row >= BURST

    def keep(self, scheduler: Scheduler) -> None:
        """Advance time before a message that follows many others without a wait in between.

        Raises:
            RunOver: the run is over.
        """
        thread = scheduler.current
        if thread is None or not scheduler.may_wait:
            return
        is_busy = (
            thread is self._thread
            and thread.waits == self._waits
            and scheduler.now_ns - self._last_ns <= _AT_ONCE_NS
        )
        self._in_row = self._in_row + 1 if is_busy else 0
        if self.is_of_loop:
            scheduler.pass_until(self._last_ns + PERIOD_NS)
        self._thread, self._waits, self._last_ns = thread, thread.waits, scheduler.now_ns
