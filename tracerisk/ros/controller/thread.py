"""A thread of the controller, what it waits for, and the exception that ends it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any, Literal, Protocol

from tracerisk.errors import Location
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.trace import EndCause

WaitKind = Literal["blocked", "idle", "unmet"]
"""What a thread waits for: another thread, work from outside (`spin`), or a thing that must
exist before it can go on (a service, a message, a goal's result)."""


class RunOver(BaseException):
    """Ends the controller: raised at every wait once the run is over.

    It is no `Exception`, so that a controller's own handlers let it pass; one that catches it
    all the same gets it again at its next wait.
    `stack` is place and function of the controller's frames that wait, outermost first.
    """

    def __init__(
        self,
        cause: EndCause,
        message: str,
        location: Location | None = None,
        stack: tuple[tuple[Location, str], ...] = (),
    ) -> None:
        super().__init__(message)
        self.cause = cause
        self.message = message
        self.location = location
        self.stack = stack

    def again(self) -> RunOver:
        """Make an equal one to raise: an exception carries the traceback of one raise only."""
        return RunOver(self.cause, self.message, self.location, self.stack)


class HoldsLock(Protocol):
    """A lock that knows which thread holds it."""

    @property
    def holder(self) -> ControllerThread | None:
        """The thread that acquired it last, while it is held."""
        ...


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a wait means at one instant: while a thread waits, others may change it."""

    kind: WaitKind
    """What it means if the wait never ends."""
    why: str = ""
    """Why nothing ends it, in words; empty where nothing is known."""


@dataclass(slots=True, eq=False)
class Wait:
    """What a thread waits for, and since when (a sequence number, and simulated time [ns]).

    `meaning` returns what the wait means now.
    """

    since: int
    since_ns: int
    predicate: Callable[[], bool] | None
    deadline_ns: int | None
    reason: str
    meaning: Callable[[], Meaning]
    on: HoldsLock | ControllerThread | None
    frame: FrameType | None = None
    satisfied: bool = False

    @property
    def kind(self) -> WaitKind:
        """What it means if the wait never ends, as things are now."""
        return self.meaning().kind


@dataclass(slots=True, eq=False)
class ControllerThread:
    """A thread under the baton; `process` is the companion whose code it runs, None for none.

    `gate` is what it waits at for the baton.
    `is_undisturbed`: it reads the clock, and nobody else has a turn meanwhile.
    """

    name: str
    number: int
    daemon: bool
    is_main: bool = False
    is_controllers: bool = True
    finished: bool = False
    gate: Any = None
    wait: Wait | None = None
    ident: int | None = None
    spins_since_ns: int | None = None
    read_ns: int = -1
    is_undisturbed: bool = False
    calls: int = 0
    calls_ns: int = -1
    waits: int = 0
    """How often it has slept or waited for something, and not only looked at the clock."""
    raises: int = 0
    interrupt: BaseException | None = None
    signals: list[Callable[[], object]] = field(default_factory=list)
    """Handlers of signals that it is to run before it goes on; only the main thread has any."""
    process: NodeProcess | None = None
    at_finish: list[Callable[[], None]] = field(default_factory=list)


@contextmanager
def undisturbed(thread: ControllerThread | None) -> Iterator[None]:
    """Keep the clock, while it lasts, from moving because the thread reads it."""
    if thread is None or thread.is_undisturbed:
        yield
        return
    thread.is_undisturbed = True
    try:
        yield
    finally:
        thread.is_undisturbed = False


@contextmanager
def spinning(thread: ControllerThread | None, now_ns: int) -> Iterator[None]:
    """Mark, while it lasts, that a thread itself runs callbacks, and without an end."""
    if thread is None or thread.spins_since_ns is not None:
        yield
        return
    thread.spins_since_ns = now_ns
    try:
        yield
    finally:
        thread.spins_since_ns = None
