"""A thread of the controller, what it waits for, and the exception that ends it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FrameType
from typing import Any, Literal, Protocol

from tracerisk.errors import Location
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.controller.programs import Awaited
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
    """What a thread waits for."""

    since: int
    """The sequence number of its begin: of threads that can go on the lowest goes first."""
    since_ns: int
    """The simulated time of its begin [ns]."""
    predicate: Callable[[], bool] | None
    """The condition that ends the wait; `None` for a mere passing of time."""
    deadline_ns: int | None
    """The simulated time at which it ends in any case [ns]; `None`: never."""
    reason: str
    """What it waits for, in words: `service /add (pkg/Add)`."""
    meaning: Callable[[], Meaning]
    """A function that returns what the wait means at present."""
    on: HoldsLock | ControllerThread | None
    """The lock or thread that could end it; `None` where there is none."""
    awaited: Awaited | None = None
    """What a program of the controller may bring that ends it; `None`: nothing."""
    frame: FrameType | None = None
    """The Python frame that waits; `None` while the thread does not wait."""
    satisfied: bool = False
    """Whether the predicate, and not the deadline, ended it."""

    @property
    def kind(self) -> WaitKind:
        """What it means if the wait never ends, as things are now."""
        return self.meaning().kind


@dataclass(slots=True, eq=False)
class ControllerThread:
    """A thread under the baton."""

    name: str
    """The name of the thread."""
    number: int
    """Its rank by creation, unique in the run."""
    daemon: bool
    """Whether the run may end while it is alive."""
    is_main: bool = False
    """Whether it is the main thread of the controller."""
    is_controllers: bool = True
    """Whether it is the controller's own; False for a library's and a companion's."""
    finished: bool = False
    """Whether its function has returned."""
    gate: Any = None
    """The lock or greenlet at which it waits for the baton."""
    wait: Wait | None = None
    """What it waits for; `None` while it has the baton."""
    ident: int | None = None
    """The identifier that Python gives it; `None` before it starts."""
    spins_since_ns: int | None = None
    """The simulated time since which it runs callbacks itself [ns]; `None`: it does not."""
    read_ns: int = -1
    """The simulated time at which it last looked at the clock [ns]; -1: not since it worked."""
    is_undisturbed: bool = False
    """Whether its looks at the clock move no time."""
    calls: int = 0
    """The number of non-waiting calls at the instant `calls_ns`, weighted by their cost."""
    calls_ns: int = -1
    """The simulated instant that `calls` belongs to [ns]; -1 before the first call."""
    waits: int = 0
    """The number of its sleeps and waits, without looks at the clock."""
    raises: int = 0
    """The number of times that the end of the run was raised in it."""
    interrupt: BaseException | None = None
    """The exception to raise at the end of its wait; `None`: none."""
    signals: list[Callable[[], object]] = field(default_factory=list)
    """The handlers of signals to run before it goes on; only the main thread has any."""
    process: NodeProcess | None = None
    """The companion whose code it runs; `None` for the controller's."""
    at_finish: list[Callable[[], None]] = field(default_factory=list)
    """The functions to call when it has finished."""


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
