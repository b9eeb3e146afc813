"""Clocks, all of which return the simulated time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import IntEnum
from typing import Any

from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.time.clock import EPOCH_NS, MONOTONIC_START_NS

from ._run import run
from .clock_type import ClockType
from .context import Context
from .duration import Duration
from .exceptions import NotInitializedException
from .time import Time


class ClockChange(IntEnum):
    """How the source of a clock's time changed."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


class JumpThreshold:
    """How far a clock must jump for a callback.

    Raises:
        ValueError: a threshold has the wrong sign, or there is none.
    """

    def __init__(
        self,
        *,
        min_forward: Duration | None,
        min_backward: Duration | None,
        on_clock_change: bool = True,
    ) -> None:
        if min_forward is not None and min_forward.nanoseconds <= 0:
            raise ValueError("min_forward must be a positive non-zero duration")
        if min_backward is not None and min_backward.nanoseconds >= 0:
            raise ValueError("min_backward must be a negative non-zero duration")
        if min_forward is None and min_backward is None and not on_clock_change:
            raise ValueError("At least one jump threshold must be enabled")
        self.min_forward = min_forward
        self.min_backward = min_backward
        self.on_clock_change = on_clock_change


class TimeJump:
    """A jump of a clock."""

    def __init__(self, clock_change: ClockChange, delta: Duration) -> None:
        if not isinstance(clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
        self.clock_change = clock_change
        self.delta = delta


class JumpHandle:
    """A callback for the jumps of a clock, from `create_jump_callback` to `unregister`.

    Raises:
        ValueError: there is no callback, or one that cannot be called.
    """

    def __init__(
        self, *, clock: Clock, threshold: JumpThreshold, pre_callback: Any, post_callback: Any
    ) -> None:
        if pre_callback is None and post_callback is None:
            raise ValueError("One of pre_callback or post_callback must be callable")
        for name, callback in (("pre_callback", pre_callback), ("post_callback", post_callback)):
            if callback is not None and not callable(callback):
                raise ValueError(f"{name} must be callable if given")
        self._clock: Clock | None = clock
        self._threshold = threshold
        self._pre_callback = pre_callback
        self._post_callback = post_callback
        clock._jump_handles.append(self)

    def unregister(self) -> None:
        """Forget the callback."""
        if self._clock is not None:
            self._clock._jump_handles.remove(self)
            self._clock = None

    def _is_about(self, jump: TimeJump) -> bool:
        wanted = self._threshold
        if jump.clock_change in _CHANGES:
            return wanted.on_clock_change
        length_ns = jump.delta.nanoseconds
        return (wanted.min_forward is not None and length_ns >= wanted.min_forward.nanoseconds) or (
            wanted.min_backward is not None and length_ns <= wanted.min_backward.nanoseconds
        )

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *error: object) -> None:
        self.unregister()


_CHANGES = (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED)


class Clock:
    """A clock of one kind."""

    def __new__(cls, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> Clock:
        """Make a clock of a kind: a ROSClock for ROS time."""
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        made = super().__new__(ROSClock if clock_type is ClockType.ROS_TIME else cls)
        made._clock_type = clock_type
        return made

    def __init__(self, *, clock_type: ClockType = ClockType.SYSTEM_TIME) -> None:
        self._clock_type = clock_type
        self._jump_handles: list[JumpHandle] = []

    @property
    def clock_type(self) -> ClockType:
        """The kind of the clock."""
        return self._clock_type

    def __repr__(self) -> str:
        return f"Clock(clock_type={self.clock_type.name})"

    def now(self) -> Time:
        """Return the time; a second reading at one instant is 1 ms later."""
        run().scheduler.touch()
        return Time(nanoseconds=self._reported_ns, clock_type=self._clock_type)

    @property
    def _reported_ns(self) -> int:
        """What the clock shows [ns]; asking for it moves nothing."""
        return self._start_ns + run().scheduler.now_ns

    @property
    def _start_ns(self) -> int:
        """What the clock shows when the run begins [ns]."""
        return MONOTONIC_START_NS if self._clock_type is ClockType.STEADY_TIME else EPOCH_NS

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until a time; False where the context was shut down before.

        Raises:
            ValueError: the time is one of another kind of clock.
            NotInitializedException: the context is not initialized.
        """
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        return self._sleep(until.nanoseconds - self._start_ns - run().scheduler.now_ns, context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a span; False where the context was shut down before.

        Raises:
            NotInitializedException: the context is not initialized.
        """
        # The real one adds the span to a time, which refuses what is no span.
        return self._sleep((self.now() + rel_time).nanoseconds - self.now().nanoseconds, context)

    def create_jump_callback(
        self, threshold: JumpThreshold, *, pre_callback: Any = None, post_callback: Any = None
    ) -> JumpHandle:
        """Report jumps of the clock; see `JumpHandle`."""
        return JumpHandle(
            clock=self,
            threshold=threshold,
            pre_callback=pre_callback,
            post_callback=post_callback,
        )

    def _sleep(self, length_ns: int, context: Context | None) -> bool:
        scheduler = run().scheduler
        known = _living(context)
        if length_ns <= 0:
            scheduler.sleep(0)
            return True
        is_interrupted = self._is_interrupted()
        return not scheduler.wait_until(
            lambda: not known.is_valid or is_interrupted(),
            timeout_ns=length_ns,
            reason="time to pass",
        )

    def _is_interrupted(self) -> Callable[[], bool]:
        """Return a test of whether a sleep that begins now is over before its time."""
        return lambda: False


class ROSClock(Clock):
    """The clock of ROS time: the simulated time, or what it is set to while that is active."""

    def __new__(cls, **kwargs: Any) -> ROSClock:
        """Make a clock of ROS time."""
        del kwargs
        made = object.__new__(cls)
        made._clock_type = ClockType.ROS_TIME
        return made

    def __init__(self, **kwargs: Any) -> None:
        del kwargs
        super().__init__(clock_type=ClockType.ROS_TIME)
        self._is_set = False
        self._set_ns = 0
        self._n_switches = 0

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clock shows what it is set to; a `TimeSource` sets it to `/clock`."""
        return self._is_set

    def set_ros_time_override(self, time: Time) -> None:
        """Set the clock; it shows that while ROS time is active.

        Raises:
            TypeError: it is no Time.
        """
        if not isinstance(time, Time):
            raise TypeError(
                f"Time must be specified as rclpy.time.Time. Received type: {type(time)}"
            )
        jump = TimeJump(
            ClockChange.ROS_TIME_NO_CHANGE, Duration(nanoseconds=time.nanoseconds - self._set_ns)
        )
        if not self._is_set:
            self._set_ns = time.nanoseconds
            return
        with self._jumping(jump):
            self._set_ns = time.nanoseconds

    def _set_ros_time_is_active(self, enabled: bool) -> None:
        if self._is_set == enabled:
            return
        change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        with self._jumping(TimeJump(change, Duration())):
            self._is_set = enabled
            self._n_switches += 1

    @contextmanager
    def _jumping(self, jump: TimeJump) -> Iterator[None]:
        concerned = [
            jump_handle for jump_handle in self._jump_handles if jump_handle._is_about(jump)
        ]
        for jump_handle in concerned:
            if jump_handle._pre_callback is not None:
                jump_handle._pre_callback()
        yield
        for jump_handle in concerned:
            if jump_handle._post_callback is not None:
                jump_handle._post_callback(jump)

    @property
    def _reported_ns(self) -> int:
        return self._set_ns if self._is_set else super()._reported_ns

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until a time; False also where ROS time becomes active or inactive meanwhile."""
        if not self._is_set or until.clock_type != self._clock_type:
            return super().sleep_until(until, context)
        return self._sleep_while_set(until.nanoseconds, context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a span; False also where ROS time becomes active or inactive meanwhile."""
        if not self._is_set:
            return super().sleep_for(rel_time, context)
        return self._sleep_while_set(self._set_ns + rel_time.nanoseconds, context)

    def _sleep_while_set(self, until_ns: int, context: Context | None) -> bool:
        known = _living(context)
        switches = self._n_switches
        run().scheduler.wait_until(
            lambda: self._set_ns >= until_ns or self._n_switches != switches or not known.is_valid,
            reason="a clock that follows a topic or a program",
            kind="unmet",
        )
        return known.is_valid and self._n_switches == switches

    def _is_interrupted(self) -> Callable[[], bool]:
        switches = self._n_switches
        return lambda: self._n_switches != switches


def _living(context: Context | None) -> Context:
    known = run().default_context if context is None else context
    if not known.is_valid:
        raise NotInitializedException
    return known


__all__ = _defined(globals(), "ClockType", "Time")
