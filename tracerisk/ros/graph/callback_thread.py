"""A thread that runs a client library's callbacks one after the other, as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import Any

from tracerisk.ros.time.scheduler import CallTracer, Scheduler


@dataclass(eq=False)
class CallbackThread:
    """Runs calls one after the other, each as a root of its own.

    The thread is started by the first call.
    """

    _scheduler: Scheduler
    """The scheduler of the run."""
    _tracer: CallTracer | None
    """The tracer in which each call is a root; `None` without tracing."""
    _name: str
    """The name of the thread."""
    limit: int | None = None
    """How many calls may wait before the oldest is dropped, as from a full socket buffer; `None`:
    any number."""
    _calls: deque[Callable[[], object]] = field(default_factory=deque)
    """The calls that wait, the oldest first."""
    _is_started: bool = False
    """Whether the thread has been started."""
    _is_closed: bool = False
    """Whether it accepts no more calls."""

    @property
    def n_waiting(self) -> int:
        """How many calls wait."""
        return len(self._calls)

    def put(self, call: Callable[[], object]) -> None:
        """Run `call` when the thread gets its turn; it must raise nothing."""
        if self._is_closed:
            return
        self._calls.append(call)
        while self.limit is not None and len(self._calls) > self.limit:
            self._calls.popleft()
        if not self._is_started:
            self._is_started = True
            self._scheduler.spawn(self._serve, self._name, inherit=False, is_controllers=False)

    def give_turn(self) -> None:
        """Run now what was handed to it, unless it is blocked within an earlier call."""
        if self._calls:
            self._scheduler.pass_until(self._scheduler.now_ns)

    def close(self) -> None:
        """Drop what waits and end the thread."""
        self._is_closed = True
        self._calls.clear()

    def _serve(self) -> None:
        while True:
            self._scheduler.wait_until(
                lambda: bool(self._calls) or self._is_closed,
                reason="messages",
                kind="idle",
            )
            if self._is_closed:
                return
            call = self._calls.popleft()
            root: Any = nullcontext()
            if self._tracer is not None:
                root = self._tracer.root("callback")
            with root:
                call()
