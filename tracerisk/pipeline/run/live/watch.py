"""The controller's threads in another process, as what watches a run asks about them."""

from __future__ import annotations

from dataclasses import dataclass, field

from tracerisk.errors import Location
from tracerisk.ros.controller.thread import ControllerThread, RunOver
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.trace import EndCause

HURRY_S = 10.0
"""How long a node without input may send without a wait before it is one that never ends [s]."""
_SILENT_S = 1.0


@dataclass(slots=True)
class _Ident:
    of: int = 0
    """The number of the thread that has just sent something."""

    def ident(self) -> int:
        return self.of


@dataclass(slots=True)
class RemoteThreads:
    """Stands for the scheduler before a `RunWatch`: its clock, and the controller's threads."""

    scheduler: Scheduler
    """The scheduler of the twin, whose clock counts."""
    baton: _Ident = field(default_factory=_Ident)
    """The thread that has just sent something."""
    main: ControllerThread = field(
        default_factory=lambda: ControllerThread("MainThread", 0, daemon=False, is_main=True)
    )
    """The main thread of the controller, the only one known."""
    over: RunOver | None = None
    """How the run is over; `None` while it goes on."""
    last_ns: int = 0
    """When the controller sent or asked anything last, simulated time [ns]."""
    _hurries_since_ns: int | None = None

    @property
    def now_ns(self) -> int:
        """The simulated time [ns]."""
        return self.scheduler.now_ns

    @property
    def threads(self) -> tuple[ControllerThread, ...]:
        """The threads that are known: the main one."""
        return (self.main,)

    def acts(self, thread: int) -> None:
        """Note which of the controller's threads has sent what comes next."""
        self.baton.of = thread

    def raise_if_over(self) -> None:
        """Do nothing: the controller is ended from outside."""

    def end(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        """Note that the run is over.

        Where the main thread spins and has sent nothing since, nothing can happen any more: that is
        a good end without a command too.
        """
        since_ns = self.main.spins_since_ns
        if cause == "no_motion" and since_ns is not None and self.last_ns <= since_ns:
            cause, message = "quiescent", "the controller spins, and has sent nothing since"
        if self.over is None:
            self.over = RunOver(cause, message, location)

    def stirred(self) -> None:
        """Note that the controller has sent or asked something."""
        self.last_ns = self.now_ns

    def spins(self, *, alone: bool) -> None:
        """Note whether the main thread waits for callbacks alone from now on."""
        if not alone:
            self.main.spins_since_ns = None
        elif self.main.spins_since_ns is None:
            self.main.spins_since_ns = self.now_ns

    def look_without_input(self, *, waits: bool) -> None:
        """End a run that asked for more input than there was, and sends without a wait for long.

        A menu that reads nothing gets its next answer at once, and never ends.
        """
        if waits or self.now_ns - self.last_ns > _SILENT_S * 1e9:
            self._hurries_since_ns = None
        elif self._hurries_since_ns is None:
            self._hurries_since_ns = self.now_ns
        elif self.now_ns - self._hurries_since_ns >= HURRY_S * 1e9:
            self.end(
                "idle", f"its input has ended, and it has sent for {HURRY_S:g} s without a wait"
            )
