"""Spans of time."""

from __future__ import annotations

from functools import total_ordering
from typing import Any

from builtin_interfaces.msg import Duration as DurationMessage

from .constants import S_TO_NS

_LIMIT = 2**63


@total_ordering
class Duration:
    """A span of time, in whole nanoseconds; it may be negative.

    Raises:
        OverflowError: it does not fit into 64 bits.
    """

    def __init__(self, *, seconds: float = 0, nanoseconds: float = 0) -> None:
        total = int(seconds * S_TO_NS) + int(nanoseconds)
        if not -_LIMIT <= total < _LIMIT:
            raise OverflowError("Total nanoseconds value is too large to store in C duration.")
        self._nanoseconds = total

    @property
    def nanoseconds(self) -> int:
        """The length [ns]."""
        return self._nanoseconds

    def __repr__(self) -> str:
        return f"Duration(nanoseconds={self.nanoseconds})"

    def __str__(self) -> str:
        if self.nanoseconds == _LIMIT - 1:
            return "Infinite"
        return f"{self.nanoseconds} nanoseconds"

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Duration):
            return self.nanoseconds == other.nanoseconds
        # Infinite is of another class in the real library, and equal by its length too.
        return NotImplemented

    def __lt__(self, other: Any) -> bool:
        if not isinstance(other, Duration):
            return NotImplemented
        return self.nanoseconds < other.nanoseconds

    __hash__ = None  # type: ignore[assignment]  # as in the real library

    def to_msg(self) -> Any:
        """Return the span as a builtin_interfaces/Duration."""
        sec, nanosec = divmod(self.nanoseconds, S_TO_NS)
        return DurationMessage(sec=sec, nanosec=nanosec)

    @classmethod
    def from_msg(cls, msg: Any) -> Duration:
        """Return the span of a builtin_interfaces/Duration.

        Raises:
            TypeError: the message is another.
        """
        if not isinstance(msg, DurationMessage):
            raise TypeError("Must pass a builtin_interfaces.msg.Duration object")
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec)


Infinite = Duration(nanoseconds=_LIMIT - 1)
"""The longest span: for ever."""
