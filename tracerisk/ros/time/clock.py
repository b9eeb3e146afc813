"""The functions of `time`, `datetime` and `select` that read or wait on virtual time."""

from __future__ import annotations

import datetime as dt
import math
import select
import time
from collections.abc import Callable
from sys import _getframe
from types import FrameType
from typing import Any

from tracerisk.ros.controller.frames import is_quiet
from tracerisk.ros.controller.programs import Awaited
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import NANOSECONDS, nanoseconds

EPOCH_NS = 1_767_225_600 * NANOSECONDS
"""What `time.time_ns()` returns at simulated time zero: 2026-01-01T00:00:00Z [ns]."""
MONOTONIC_START_NS = 10_000 * NANOSECONDS
"""What `time.monotonic_ns()` returns at simulated time zero; just booted machines are rare."""


class VirtualClock:
    """The replacements, by the name of what they replace: `functions("time")`."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler

    def _now(self, frame: FrameType) -> int | None:
        """Return the simulated time for a reader [ns], or None for a thread of another's."""
        scheduler = self._scheduler
        if scheduler.current is None:
            return None
        return scheduler.now_ns if is_quiet(frame) else scheduler.read_clock()

    def time_functions(self) -> dict[str, Callable[..., Any]]:
        """Return the replacements in the module `time`."""
        readers = {
            "time": EPOCH_NS,
            "monotonic": MONOTONIC_START_NS,
            "perf_counter": MONOTONIC_START_NS,
            "process_time": 0,
            "thread_time": 0,
        }
        functions: dict[str, Callable[..., Any]] = {"sleep": self.sleep}
        for name, start_ns in readers.items():
            functions[name] = self._reader(getattr(time, name), start_ns, NANOSECONDS)
            functions[name + "_ns"] = self._reader(getattr(time, name + "_ns"), start_ns, 1)
        for name in ("localtime", "gmtime", "ctime"):
            functions[name] = self._with_default_time(getattr(time, name))
        functions["asctime"] = self._with_default_tuple(time.asctime, 0)
        functions["strftime"] = self._with_default_tuple(time.strftime, 1)
        functions["clock_gettime"] = self._by_clock(time.clock_gettime, NANOSECONDS)
        functions["clock_gettime_ns"] = self._by_clock(time.clock_gettime_ns, 1)
        return functions

    def sleep(self, seconds: float, /) -> None:
        """Sleep; see `time.sleep`."""
        if not self._scheduler.may_wait:
            _real_sleep(seconds)
            return
        if not hasattr(seconds, "__float__") and not hasattr(seconds, "__index__"):
            kind = type(seconds).__name__
            raise TypeError(f"'{kind}' object cannot be interpreted as an integer")
        length = float(seconds)
        if math.isnan(length):
            raise ValueError("Invalid value NaN (not a number)")
        if length < 0:
            raise ValueError("sleep length must be non-negative")
        if length > _LONGEST_SLEEP_S:
            raise OverflowError("timestamp too large to convert to C PyTime_t")
        self._scheduler.sleep(nanoseconds(length))

    def select(
        self, read: Any, write: Any, exceptional: Any, timeout: float | None = None, /
    ) -> Any:
        """Wait in virtual time until a file is ready; see `select.select`."""
        if self._scheduler.current is None:
            return _real_select(read, write, exceptional, timeout)
        result: list[Any] = []

        def is_ready() -> bool:
            result[:] = [_real_select(read, write, exceptional, 0)]
            return any(result[0])

        self._scheduler.wait_until(
            is_ready,
            timeout_ns=None if timeout is None else nanoseconds(timeout),
            reason="a file to be ready",
            kind="idle",
            awaited=Awaited(
                descriptors=tuple(map(_descriptor, (*read, *write, *exceptional))), limit_s=timeout
            ),
        )
        return result[0]

    def _reader(
        self, real: Callable[[], Any], start_ns: int, units_per_s: int
    ) -> Callable[[], Any]:
        def read() -> Any:
            now_ns = self._now(_getframe(1))
            if now_ns is None:
                return real()
            return start_ns + now_ns if units_per_s == 1 else (start_ns + now_ns) / units_per_s

        return _named_as(read, real)

    def _with_default_time(self, real: Callable[..., Any]) -> Callable[..., Any]:
        def convert(seconds: float | None = None, /) -> Any:
            if seconds is None:
                now_ns = self._now(_getframe(1))
                seconds = None if now_ns is None else (EPOCH_NS + now_ns) / NANOSECONDS
            return real(seconds)

        return _named_as(convert, real)

    def _with_default_tuple(self, real: Callable[..., Any], position: int) -> Callable[..., Any]:
        def convert(*args: Any) -> Any:
            if len(args) == position:
                now_ns = self._now(_getframe(1))
                if now_ns is not None:
                    args = (*args, _real_localtime((EPOCH_NS + now_ns) / NANOSECONDS))
            return real(*args)

        return _named_as(convert, real)

    def _by_clock(self, real: Callable[[int], Any], units_per_s: int) -> Callable[[int], Any]:
        def read(clock: int, /) -> Any:
            start_ns = EPOCH_NS if clock == time.CLOCK_REALTIME else MONOTONIC_START_NS
            now_ns = self._now(_getframe(1))
            if now_ns is None:
                return real(clock)
            return start_ns + now_ns if units_per_s == 1 else (start_ns + now_ns) / units_per_s

        return _named_as(read, real)

    def date_classes(self) -> dict[str, type]:
        """Return the replacements in the module `datetime`: classes that take theirs for own."""
        clock = self

        def seconds(frame: FrameType) -> float:
            now_ns = clock._now(frame)
            return time.time() if now_ns is None else (EPOCH_NS + now_ns) / NANOSECONDS

        class Date(dt.date, metaclass=_KindOf):
            @classmethod
            def today(cls) -> Any:
                return cls.fromtimestamp(seconds(_getframe(1)))

            def __repr__(self) -> str:
                return _with_module(super().__repr__(), type(self) is Date)

        class DateTime(dt.datetime, metaclass=_KindOf):
            @classmethod
            def now(cls, tz: dt.tzinfo | None = None) -> Any:
                return cls.fromtimestamp(seconds(_getframe(1)), tz)

            @classmethod
            def utcnow(cls) -> Any:
                aware = cls.fromtimestamp(seconds(_getframe(1)), dt.timezone.utc)
                return aware.replace(tzinfo=None)

            @classmethod
            def today(cls) -> Any:
                return cls.fromtimestamp(seconds(_getframe(1)))

            def __repr__(self) -> str:
                return _with_module(super().__repr__(), type(self) is DateTime)

        classes: dict[str, type] = {"date": Date, "datetime": DateTime}
        for name, replacement in classes.items():
            # Pickles and representations must name the class that they are found under.
            replacement.__module__, replacement.__qualname__ = "datetime", name
            replacement.__name__ = name
        return classes


class _KindOf(type):
    """The class of a subclass that answers `isinstance` as its base does."""

    def __instancecheck__(cls, instance: object) -> bool:
        return cls.__subclasscheck__(type(instance))

    def __subclasscheck__(cls, subclass: type) -> bool:
        # A controller's own subclass of ours is an ordinary class again.
        if type(cls.__base__) is _KindOf:
            return super().__subclasscheck__(subclass)
        return issubclass(subclass, cls.__base__ or object)


def _with_module(text: str, is_ours: bool) -> str:
    # A class written in Python is shown without its module, the one in C with it.
    return f"datetime.{text}" if is_ours else text


def _named_as(function: Callable[..., Any], real: Callable[..., Any]) -> Callable[..., Any]:
    function.__name__ = function.__qualname__ = real.__name__
    function.__doc__ = real.__doc__
    function.__module__ = real.__module__
    return function


def _descriptor(file: Any) -> int:
    return int(file if isinstance(file, int) else file.fileno())


_LONGEST_SLEEP_S = (2**63 - 1) / NANOSECONDS
_real_sleep = time.sleep
_real_localtime = time.localtime
_real_select = select.select
