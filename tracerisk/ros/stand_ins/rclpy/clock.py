"""Clocks, all of which tell the simulated time."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from tracerisk.ros.time.clock import EPOCH_NS, MONOTONIC_START_NS

from ._run import run
from .clock_type import ClockType
from .context import Context
from .duration import Duration
from .exceptions import NotInitializedException
from .time import Time

__all__ = [
    "Clock",
    "ClockChange",
    "ClockType",
    "JumpHandle",
    "JumpThreshold",
    "ROSClock",
    "Time",
    "TimeJump",
]


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
    """A callback for jumps; simulated time makes none, so it is never called.

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

    def unregister(self) -> None:
        """Forget the callback."""
        self._clock = None

    def __enter__(self) -> JumpHandle:
        return self

    def __exit__(self, *error: object) -> None:
        self.unregister()


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

    @property
    def clock_type(self) -> ClockType:
        """The kind of the clock."""
        return self._clock_type

    def __repr__(self) -> str:
        return f"Clock(clock_type={self.clock_type.name})"

    def now(self) -> Time:
        """Return the time; a second reading at one instant is 1 ms later."""
        start_ns = MONOTONIC_START_NS if self._clock_type is ClockType.STEADY_TIME else EPOCH_NS
        now_ns = start_ns + run().scheduler.read_clock()
        return Time(nanoseconds=now_ns, clock_type=self._clock_type)

    def sleep_until(self, until: Time, context: Context | None = None) -> bool:
        """Sleep until a time; False where the context was shut down before.

        Raises:
            ValueError: the time is one of another kind of clock.
            NotInitializedException: the context is not initialized.
        """
        if until.clock_type != self._clock_type:
            raise ValueError("until's clock type does not match this clock's type")
        start_ns = MONOTONIC_START_NS if self._clock_type is ClockType.STEADY_TIME else EPOCH_NS
        return self._sleep(until.nanoseconds - start_ns - run().scheduler.now_ns, context)

    def sleep_for(self, rel_time: Duration, context: Context | None = None) -> bool:
        """Sleep for a span; False where the context was shut down before.

        Raises:
            NotInitializedException: the context is not initialized.
        """
        return self._sleep(rel_time.nanoseconds, context)

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
        state = run()
        known = state.default_context if context is None else context
        if not known.is_valid:
            raise NotInitializedException
        if length_ns <= 0:
            state.scheduler.sleep(0)
            return True
        return not state.scheduler.wait_until(
            lambda: not known.is_valid, timeout_ns=length_ns, reason="time to pass"
        )


class ROSClock(Clock):
    """The clock that follows `/clock`; it is the simulated time in any case."""

    def __new__(cls, **kwargs: Any) -> ROSClock:
        """Make a clock of ROS time."""
        del kwargs
        made = object.__new__(cls)
        made._clock_type = ClockType.ROS_TIME
        return made

    def __init__(self, **kwargs: Any) -> None:
        del kwargs
        self._clock_type = ClockType.ROS_TIME

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clock follows `/clock`."""
        return False
