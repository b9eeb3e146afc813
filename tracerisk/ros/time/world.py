"""What virtual time is built between: a world that moves, and a tracer of the controller."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any, Protocol


class World(Protocol):
    """What moves while the controller waits: the twin, or a clock."""

    @property
    def time_ns(self) -> int:
        """The time of the world [ns]."""

    @property
    def busy(self) -> bool:
        """Whether a motion is live."""

    def advance(self, until_ns: int) -> int:
        """Move to `until_ns`, or return at the end of the step in which a motion ended [ns]."""


class CallTracer(Protocol):
    """What the scheduler needs of a tracer: the stack that a new thread inherits."""

    def capture(self) -> Any:
        """Return the stack of the calling thread."""

    def resume(self, captured: Any, /) -> AbstractContextManager[Any]:
        """Go on with a captured stack."""

    def root(self, kind: Any, /) -> AbstractContextManager[Any]:
        """Begin an empty stack: a callback's."""
