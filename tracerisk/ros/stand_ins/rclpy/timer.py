"""Timers and rates, in simulated time."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from operator import attrgetter
from typing import Any

from ._entity import Call, Entity
from ._handle import GONE
from ._rclpy_pybind11 import RCLError
from ._run import run
from .callback_groups import CallbackGroup
from .clock import Clock
from .clock_type import ClockType
from .context import Context
from .exceptions import InvalidHandle, ROSInterruptException
from .executors import await_or_execute
from .time import Time


class TimerInfo:
    """When a timer's callback was due, and when it was called [ns].

    Raises:
        TypeError: `clock_type` is none.
        ValueError: a time is negative.
    """

    def __init__(
        self,
        *,
        expected_call_time: int = 0,
        actual_call_time: int = 0,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
    ) -> None:
        self._expected = Time(nanoseconds=expected_call_time, clock_type=clock_type)
        self._actual = Time(nanoseconds=actual_call_time, clock_type=clock_type)

    expected_call_time = property(attrgetter("_expected"), doc="When the callback was due.")

    actual_call_time = property(attrgetter("_actual"), doc="When the callback was called.")


class Timer(Entity):
    """Calls back every period; made by `Node.create_timer`."""

    _root_kind = "timer"

    def __init__(
        self,
        node: Any,
        callback: Callable[..., Any] | None,
        callback_group: CallbackGroup,
        timer_period_ns: int,
        clock: Clock,
        *,
        context: Context | None = None,
        autostart: bool = True,
    ) -> None:
        if timer_period_ns < 0:
            raise RCLError("failed to create timer: timer period must be non-negative")
        super().__init__(node, callback_group)
        self.callback = callback
        self._asked: Any = None
        self._asks_for: list[str] = []
        self._clock = clock
        self._period_ns = int(timer_period_ns)
        self._last_ns = self._now_ns()
        self._due_ns: int | None = self._last_ns + self._period_ns if autostart else None

    clock = property(attrgetter("_clock"), doc="The clock that the timer counts by.")

    @property
    def timer_period_ns(self) -> int:
        """The period [ns]; a new one counts from the next call on."""
        return self._period_ns

    @timer_period_ns.setter
    def timer_period_ns(self, value: int) -> None:
        self._period_ns = int(value)

    def is_ready(self) -> bool:
        """Return whether the timer is due."""
        self._check()
        run().scheduler.touch()
        return self._is_ready()

    def is_canceled(self) -> bool:
        """Return whether the timer was stopped."""
        self._check()
        return self._due_ns is None

    def cancel(self) -> None:
        """Stop, until `reset`."""
        self._check()
        self._due_ns = None

    def reset(self) -> None:
        """Begin a new period, also after `cancel`."""
        self._check()
        self._due_ns = self._now_ns() + self._period_ns

    def time_since_last_call(self) -> int:
        """Return how long ago the last call was [ns]."""
        self._check()
        return run().scheduler.read_clock() - self._last_ns

    def time_until_next_call(self) -> int | None:
        """Return how long it is until the next call [ns], None for a timer that was stopped."""
        self._check()
        return None if self._due_ns is None else self._due_ns - run().scheduler.read_clock()

    def _check(self) -> None:
        if self._is_destroyed:
            raise InvalidHandle(GONE)

    @staticmethod
    def _now_ns() -> int:
        return run().scheduler.now_ns

    def _is_ready(self) -> bool:
        return self._due_ns is not None and self._due_ns <= self._now_ns()

    def _take(self, executor: Any) -> Call | None:
        if not self._is_ready() or self._due_ns is None:
            return None
        now_ns = self._now_ns()
        self._last_ns = now_ns
        info = self._info(self._due_ns, now_ns)
        following_ns = self._due_ns + self._period_ns
        if following_ns < now_ns:
            # Calls that were missed are left out; the beat stays.
            behind_ns = now_ns - following_ns
            period_ns = self._period_ns
            following_ns += -(-behind_ns // period_ns) * period_ns if period_ns else behind_ns
        self._due_ns = following_ns

        async def call() -> None:
            given = dict.fromkeys(self._info_names(), info)
            callback: Any = self.callback
            # As in the real library, what is no function fails here, at the first tick.
            await await_or_execute(partial(callback, **given) if given else callback)

        return call

    def _info_names(self) -> list[str]:
        # A program may change the callback; its signature is read once.
        if self._asked is not self.callback:
            self._asked, self._asks_for = self.callback, _info_parameters(self.callback)
        return self._asks_for

    def _info(self, due_ns: int, now_ns: int) -> TimerInfo:
        start_ns = self._clock._start_ns
        return TimerInfo(
            expected_call_time=start_ns + due_ns,
            actual_call_time=start_ns + now_ns,
            clock_type=self._clock.clock_type,
        )


def _info_parameters(callback: Any) -> list[str]:
    """Return the first parameter of a callback that is annotated as a TimerInfo, if any is."""
    try:
        parameters = inspect.signature(callback).parameters.values()
    except (TypeError, ValueError):
        # A function of C has no signature to read.
        return []
    return [
        parameter.name
        for parameter in parameters
        if parameter.annotation in (TimerInfo, "TimerInfo")
    ][:1]


class Rate:
    """Sleeps until the next beat of a timer; made by `Node.create_rate`.

    The timer beats only while something spins the node in another thread.
    """

    def __init__(self, timer: Timer, *, context: Context) -> None:
        self._timer = timer
        self._is_shutdown = False
        self._is_destroyed = False
        self._has_beaten = False
        self._n_sleepers = 0
        timer.callback = self._beat
        context.on_shutdown(self._on_shutdown)

    def _beat(self) -> None:
        self._has_beaten = True

    def _on_shutdown(self) -> None:
        self._is_shutdown = True
        self.destroy()

    def destroy(self) -> None:
        """Wake who sleeps, and let nobody sleep any more."""
        self._is_destroyed = True

    def sleep(self) -> None:
        """Sleep until the timer's next beat; not at all if it has beaten since the last sleep.

        Raises:
            ROSInterruptException: the context is shut down.
            RuntimeError: the rate was destroyed.
        """
        if self._is_shutdown:
            raise ROSInterruptException
        if self._is_destroyed:
            raise RuntimeError("Rate cannot sleep because it has been destroyed")
        if self._timer._is_destroyed:
            self.destroy()
            raise InvalidHandle("Rate cannot sleep because the timer has been destroyed")
        self._n_sleepers += 1
        try:
            run().scheduler.wait_until(
                lambda: self._has_beaten or self._is_destroyed,
                reason="the timer of a rate",
                kind=self._timer._node._meaning_of_wait,
            )
        finally:
            self._n_sleepers -= 1
            if self._n_sleepers == 0:
                self._has_beaten = False
        if self._is_shutdown:
            raise ROSInterruptException
