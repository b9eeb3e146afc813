"""What is late at a publisher or a subscription: messages, signs of life, and what has expired."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._run import run
from .duration import Duration, Infinite


def span_ns(given: Duration) -> int | None:
    """Return a span of a profile [ns]; None where it is not given, or for ever."""
    is_given = 0 < given.nanoseconds < Infinite.nanoseconds
    return given.nanoseconds if is_given else None


class Watchdog:
    """Calls `missed` with a count each time that `period_ns` passes without a sign.

    It watches from the first sign on. The first miss is work that is due; the later ones alone do
    not keep a run going. With `once` it is silent from a miss until the next sign.
    """

    def __init__(
        self, period_ns: int | None, missed: Callable[[int], None], *, once: bool = False
    ) -> None:
        self._period_ns = period_ns
        self._missed = missed
        self._once = once
        self._alarm: Any = None
        self._n_missed = 0

    def sign(self) -> None:
        """Begin a new period."""
        self._arm(background=False)

    def close(self) -> None:
        """Watch no longer."""
        self._period_ns = None
        if self._alarm is not None:
            self._alarm.cancel()

    def _arm(self, *, background: bool) -> None:
        if self._period_ns is None:
            return
        if self._alarm is not None:
            self._alarm.cancel()
        scheduler = run().scheduler
        due_ns = scheduler.now_ns + self._period_ns
        self._alarm = scheduler.call_at(due_ns, self._miss, background=background)

    def _miss(self) -> None:
        self._n_missed += 1
        if not self._once:
            self._arm(background=True)
        self._missed(self._n_missed)
