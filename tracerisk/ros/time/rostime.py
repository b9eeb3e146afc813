"""The ROS 1 primitives `time` and `duration`, with the arithmetic of genpy's classes."""

from __future__ import annotations

import numbers
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing_extensions import Self

NANOSECONDS = 1_000_000_000


class TVal:
    """Seconds and nanoseconds; `nsecs` of a new value is always in [0, 1e9).

    A float `secs` is split into both and then excludes `nsecs`.

    Raises:
        ValueError: `secs` is a float and `nsecs` is not zero.
    """

    __slots__ = ["nsecs", "secs"]
    _slot_types = ("int32", "int32")

    secs: int
    nsecs: int

    def __init__(self, secs: Any = 0, nsecs: Any = 0) -> None:
        if isinstance(secs, numbers.Integral):
            self.secs, self.nsecs = int(secs), int(nsecs)
        elif nsecs != 0:
            raise ValueError("if secs is a float, nsecs cannot be set")
        else:
            self.secs, self.nsecs = _split(secs)
        self.canon()

    @classmethod
    def from_sec(cls, float_secs: float) -> Self:
        """Make a value of seconds [s]."""
        return cls(*_split(float_secs))

    def is_zero(self) -> bool:
        """Return whether both parts are zero."""
        return self.secs == 0 and self.nsecs == 0

    def set(self, secs: int, nsecs: int) -> None:
        """Set both parts as they are given."""
        self.secs, self.nsecs = secs, nsecs

    def canon(self) -> None:
        """Carry whole seconds from `nsecs` to `secs`."""
        carried, self.nsecs = divmod(self.nsecs, NANOSECONDS)
        self.secs += carried

    def to_sec(self) -> float:
        """Return the value in seconds [s]."""
        return float(self.secs) + float(self.nsecs) / 1e9

    def to_nsec(self) -> int:
        """Return the value in nanoseconds [ns]."""
        return self.secs * NANOSECONDS + self.nsecs

    def __getstate__(self) -> list[int]:
        return [self.secs, self.nsecs]

    def __setstate__(self, state: list[int]) -> None:
        self.secs, self.nsecs = state

    def __hash__(self) -> int:
        return hash((self.secs, self.nsecs))

    def __str__(self) -> str:
        return str(self.to_nsec())

    def __repr__(self) -> str:
        return f"genpy.{_kind(self).__name__}[{self.to_nsec()}]"

    def __bool__(self) -> bool:
        return not self.is_zero()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _kind(self)) and self.to_nsec() == other.to_nsec()

    def __lt__(self, other: Any) -> bool:
        return self.to_nsec() < other.to_nsec() if self._comparable(other) else NotImplemented

    def __le__(self, other: Any) -> bool:
        return self.to_nsec() <= other.to_nsec() if self._comparable(other) else NotImplemented

    def __gt__(self, other: Any) -> bool:
        return self.to_nsec() > other.to_nsec() if self._comparable(other) else NotImplemented

    def __ge__(self, other: Any) -> bool:
        return self.to_nsec() >= other.to_nsec() if self._comparable(other) else NotImplemented

    def __cmp__(self, other: Any) -> int:
        if not self._comparable(other):
            raise TypeError(f"cannot compare to non-{_kind(self).__name__}")
        return int(self > other) - int(self < other)

    def _comparable(self, other: object) -> bool:
        return isinstance(other, _kind(self))


class Time(TVal):
    """A point in time; never before zero.

    Raises:
        TypeError: the time would be negative.
    """

    __slots__ = ["nsecs", "secs"]

    def __init__(self, secs: Any = 0, nsecs: Any = 0) -> None:
        super().__init__(secs, nsecs)
        if self.secs < 0:
            raise TypeError("time values must be positive")

    def to_time(self) -> float:
        """Return the time in seconds, as `time.time()` counts [s]."""
        return self.to_sec()

    def __add__(self, other: object) -> Self:
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs + other.secs, self.nsecs + other.nsecs)

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        if isinstance(other, Time):
            return Duration(self.secs - other.secs, self.nsecs - other.nsecs)
        if isinstance(other, Duration):
            return type(self)(self.secs - other.secs, self.nsecs - other.nsecs)
        return NotImplemented


class Duration(TVal):
    """A span of time; it may be negative."""

    __slots__ = ["nsecs", "secs"]

    def __neg__(self) -> Self:
        return type(self)(-self.secs, -self.nsecs)

    def __abs__(self) -> Self:
        return self if self.secs >= 0 else -self

    def __add__(self, other: object) -> Self:
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs + other.secs, self.nsecs + other.nsecs)

    __radd__ = __add__

    def __sub__(self, other: object) -> Self:
        if not isinstance(other, Duration):
            return NotImplemented
        return type(self)(self.secs - other.secs, self.nsecs - other.nsecs)

    def __mul__(self, factor: object) -> Self:
        if isinstance(factor, numbers.Integral):
            return type(self)(self.secs * int(factor), self.nsecs * int(factor))
        if isinstance(factor, numbers.Real):
            return self.from_sec(self.to_sec() * float(factor))
        return NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, divisor: object) -> Any:
        if isinstance(divisor, numbers.Real):
            return self.from_sec(self.to_sec() / float(divisor))
        if isinstance(divisor, Duration):
            return self.to_sec() / divisor.to_sec()
        return NotImplemented

    def __floordiv__(self, divisor: object) -> Any:
        if isinstance(divisor, numbers.Real):
            return self.from_sec(self.to_sec() // float(divisor))
        if isinstance(divisor, Duration):
            return int(self.to_sec() // divisor.to_sec())
        return NotImplemented

    def __mod__(self, divisor: object) -> Self:
        if isinstance(divisor, Duration):
            return self.from_sec(self.to_sec() % divisor.to_sec())
        return NotImplemented

    def __divmod__(self, divisor: object) -> tuple[int, Self]:
        if isinstance(divisor, Duration):
            quotient, remainder = divmod(self.to_sec(), divisor.to_sec())
            return int(quotient), self.from_sec(remainder)
        return NotImplemented


def _split(seconds: float) -> tuple[int, int]:
    # Truncated towards zero, not rounded: programs compare stamps made by the real library.
    whole = int(seconds)
    return whole, int((seconds - whole) * NANOSECONDS)


def _kind(value: TVal) -> type[TVal]:
    # rospy's Time and Duration are subclasses and equal genpy's of the same kind.
    for kind in (Time, Duration):
        if isinstance(value, kind):
            return kind
    return TVal
