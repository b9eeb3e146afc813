"""Timers of `signal` in virtual time: set, read and cancelled as usual; their signal never comes.

A signal would come by the clock of the machine and change the run with its load. A run in which a
timer is due therefore ends, and says so; most are watchdogs that are cancelled in time.
"""

from __future__ import annotations

import math
import signal
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.time.event_queue import ScheduledCall
from tracerisk.ros.time.scheduler import Scheduler

_S_TO_NS = 1_000_000_000
_KINDS = frozenset({signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF})


@dataclass(frozen=True, slots=True)
class _Timer:
    """A timer that is set."""

    due: ScheduledCall
    """The event at which its signal would come."""
    interval_s: float
    """After how long it would come again [s]; 0 for never."""


class VirtualAlarm:
    """The replacements of `alarm`, `setitimer` and `getitimer` in the module `signal`."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._timers: dict[int, _Timer] = {}

    def functions(self) -> dict[str, Callable[..., Any]]:
        """Return the replacements by their names."""
        return {"alarm": self.alarm, "setitimer": self.setitimer, "getitimer": self.getitimer}

    def alarm(self, seconds: int, /) -> int:
        """Set the real-time timer to whole seconds; see `signal.alarm`."""
        if self._scheduler.current is None:
            return _real_alarm(seconds)
        if not hasattr(seconds, "__index__"):
            kind = type(seconds).__name__
            raise TypeError(f"'{kind}' object cannot be interpreted as an integer")
        left_s, _ = self._set(signal.ITIMER_REAL, "signal.alarm", float(seconds), 0.0)
        return math.ceil(left_s)

    def setitimer(
        self, which: int, seconds: float, interval: float = 0.0, /
    ) -> tuple[float, float]:
        """Set a timer, and return what was left of it and its interval; see `signal.setitimer`."""
        if self._scheduler.current is None:
            return _real_setitimer(which, seconds, interval)
        if which not in _KINDS or seconds < 0 or interval < 0:
            raise signal.ItimerError(22, "Invalid argument")
        return self._set(which, "signal.setitimer", float(seconds), float(interval))

    def getitimer(self, which: int, /) -> tuple[float, float]:
        """Return what is left of a timer and its interval; see `signal.getitimer`."""
        if self._scheduler.current is None:
            return _real_getitimer(which)
        if which not in _KINDS:
            raise signal.ItimerError(22, "Invalid argument")
        return self._left(which)

    def _left(self, which: int) -> tuple[float, float]:
        timer = self._timers.get(which)
        if timer is None:
            return 0.0, 0.0
        left_ns = max(0, timer.due.time_ns - self._scheduler.now_ns)
        return left_ns / _S_TO_NS, timer.interval_s

    def _set(
        self, which: int, function: str, seconds: float, interval: float
    ) -> tuple[float, float]:
        left = self._left(which)
        before = self._timers.pop(which, None)
        if before is not None:
            before.due.cancel()
        if seconds > 0:
            caller = sys._getframe(2)
            place = Location(caller.f_code.co_filename, caller.f_lineno)

            def come() -> None:
                self._scheduler.end(
                    "raised",
                    f"the {seconds:g} s of {function} are over in simulated time, and its signal "
                    "is not simulated; wait with a limit of time instead, or use threading.Timer",
                    place,
                )

            due_ns = self._scheduler.now_ns + round(seconds * _S_TO_NS)
            self._timers[which] = _Timer(self._scheduler.call_at(due_ns, come), interval)
        return left


_real_alarm = signal.alarm
_real_setitimer = signal.setitimer
_real_getitimer = signal.getitimer
