"""A thread that runs a client library's callbacks one after the other, as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

from tracerisk.ros.time.scheduler import CallTracer, Scheduler


class CallbackThread:
    """Runs what is handed to it, in order, each call as a root of its own.

    `limit` is how many calls may wait; the oldest are dropped, as from a full socket buffer.
    The thread is started by the first call.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        tracer: CallTracer | None,
        name: str,
        *,
        kind: str = "callback",
        limit: int | None = None,
    ) -> None:
        self.limit = limit
        self._scheduler = scheduler
        self._tracer = tracer
        self._name = name
        self._kind = kind
        self._calls: deque[Callable[[], object]] = deque()
        self._is_started = False
        self._is_closed = False

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
                root = self._tracer.root(self._kind)
            with root:
                call()
