"""Which functions of the controller sent what reaches the twin, and on whose behalf it acts."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from tracerisk.instrument.tracer import Frame
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.live.hooks import digest


class Senders:
    """The stacks with which the controller's process sent messages, known by their content.

    `acts` gets the number of the controller's thread that has sent what comes next.
    """

    def __init__(self, runtime: Runtime, acts: Callable[[int], None]) -> None:
        self._runtime = runtime
        self._acts = acts
        self._stacks: dict[str, deque[tuple[tuple[Frame, ...], int]]] = {}
        self._on_behalf: dict[Any, tuple[Frame, ...]] = {}

    def sent(self, content: str, stack: tuple[Frame, ...], thread: int) -> None:
        """Note with which stack a thread sent a content, which its digest stands for."""
        self._stacks.setdefault(content, deque()).append((stack, thread))

    def of(
        self,
        name: str,  # noqa: ARG002
        body: bytes,
        number: int | None,  # noqa: ARG002
        at_ns: int | None,  # noqa: ARG002
    ) -> tuple[Frame, ...]:
        """Return the functions that sent a body, as `Bridge.sender`; each is returned once."""
        of = digest(body)
        known = self._stacks.get(of)
        if not known:
            return ()
        stack, thread = known.popleft()
        if not known:
            del self._stacks[of]
        self._acts(thread)
        return stack

    def acting_now(self) -> tuple[Frame, ...]:
        """Return the stack on whose behalf the current thread of the twin acts; () for none."""
        return self._on_behalf.get(self._runtime.scheduler.current, ())

    @contextmanager
    def acting(self, stack: tuple[Frame, ...]) -> Iterator[None]:
        """Act on behalf of a stack."""
        thread = self._runtime.scheduler.current
        before = self._on_behalf.get(thread, ())
        self._on_behalf[thread] = stack
        try:
            yield
        finally:
            self._on_behalf[thread] = before
