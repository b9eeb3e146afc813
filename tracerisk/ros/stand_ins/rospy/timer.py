"""Sleeping, rates and timers."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

from ._node import node
from .exceptions import ROSInterruptException
from .rostime import Duration, Time, duration_ns, get_rostime


class Rate:
    """Sleep so that a loop runs `hz` times a second."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        self.last_time = get_rostime()
        self.sleep_dur = Duration(0, int(1e9 / hz))
        self._reset = reset

    def _remaining(self, curr_time: Time) -> Any:
        if self.last_time > curr_time:
            self.last_time = curr_time
        return self.sleep_dur - (curr_time - self.last_time)

    def remaining(self) -> Any:
        """Return how long the next sleep would be."""
        return self._remaining(get_rostime())

    def sleep(self) -> None:
        """Sleep for what is left of the period; a loop that is late by two starts anew.

        Raises:
            ROSInterruptException: the node shuts down before the sleep is over.
        """
        curr_time = get_rostime()
        sleep(self._remaining(curr_time))
        self.last_time = self.last_time + self.sleep_dur
        if curr_time - self.last_time > self.sleep_dur * 2:
            self.last_time = curr_time


def sleep(duration: float | Duration) -> None:
    """Sleep for seconds or a Duration; a negative one returns at once.

    Before the node is initialized it sleeps too. By the clock of the wall it sleeps on when the
    node shuts down; by that of a simulation (`/use_sim_time`) it does not.

    Raises:
        ROSInterruptException: the node shuts down before the sleep is over.
    """
    state = node()
    length_ns = duration_ns(duration)
    if length_ns < 0:
        return
    if length_ns == 0 or not state.has_simulated_time:
        state.scheduler.sleep(length_ns)
        return
    state.wait(lambda: False, length_ns, "time to pass")
    if state.is_shutdown:
        raise ROSInterruptException("ROS shutdown request")


class TimerEvent:
    """When a timer's callback should have been called and when it was, this time and the last.

    `last_duration` is how long the last callback took [s].
    """

    def __init__(
        self,
        last_expected: Any,
        last_real: Any,
        current_expected: Any,
        current_real: Any,
        last_duration: float | None,
    ) -> None:
        self.last_expected = last_expected
        self.last_real = last_real
        self.current_expected = current_expected
        self.current_real = current_real
        self.last_duration = last_duration


class Timer(threading.Thread):
    """Call `callback` with a TimerEvent every `period`, or once, on a thread of its own."""

    def __init__(
        self,
        period: Duration,
        callback: Callable[[TimerEvent], object],
        oneshot: bool = False,
        reset: bool = False,
    ) -> None:
        super().__init__()
        self._period = period
        self._callback = callback
        self._oneshot = oneshot
        self._reset = reset
        self._stopped = threading.Event()
        self.daemon = True
        self.start()

    def shutdown(self) -> None:
        """Stop firing."""
        self._stopped.set()

    def run(self) -> None:
        """Fire until the node shuts down, the timer is stopped, or once."""
        state = node()
        rate = Rate(1.0 / self._period.to_sec(), reset=self._reset)
        current_expected: Any = self._now() + self._period
        last_expected: Any = None
        last_real: Any = None
        last_duration: float | None = None
        while not self._is_over():
            try:
                rate.sleep()
            except ROSInterruptException:
                break
            if self._is_over():
                break
            current_real = self._now()
            tracer = state.runtime.tracer
            root: Any = tracer.root("timer") if tracer is not None else nullcontext()
            with root:
                self._callback(
                    TimerEvent(
                        last_expected, last_real, current_expected, current_real, last_duration
                    )
                )
            if self._oneshot:
                break
            last_duration = (self._now() - current_real).to_sec()
            last_expected, last_real = current_expected, current_real
            current_expected = current_expected + self._period

    def _is_over(self) -> bool:
        return self._stopped.is_set() or node().is_shutdown

    @staticmethod
    def _now() -> Time:
        # The timer's own looks at the clock are no busy wait of the controller's.
        with node().scheduler.kernel():
            return get_rostime()
