"""A selector that waits in virtual time, so that asyncio's own event loop runs on it."""

from __future__ import annotations

import functools
import math
import os
import selectors
import stat
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tracerisk.ros.controller.programs import Awaited
from tracerisk.ros.time.busy_wait import POLL_COST
from tracerisk.ros.time.processes.programs import may_answer
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import NANOSECONDS

_RealSelector = selectors.DefaultSelector

Ready = list[tuple[selectors.SelectorKey, int]]
"""Files that are ready, each with the events."""


class VirtualSelector(selectors.BaseSelector):
    """Asks a real selector what is ready, and waits for it in virtual time.

    An event loop with nothing to wait for polls with a timeout of zero: a coroutine that yields
    again and again is a busy wait, and ends as one.
    """

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._real = _RealSelector()

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Register a file object; see `selectors.BaseSelector.register`."""
        return self._real.register(fileobj, events, data)

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        """Forget a file object; see `selectors.BaseSelector.unregister`."""
        return self._real.unregister(fileobj)

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        """Change what a file object is watched for."""
        return self._real.modify(fileobj, events, data)

    def select(self, timeout: float | None = None) -> Ready:
        """Return what is ready, after at most `timeout` seconds of virtual time."""
        return selected(self._scheduler, self._real, self._real.select, timeout)

    def close(self) -> None:
        """Close the real selector."""
        self._real.close()

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        """Return what is registered."""
        return self._real.get_map()


def selected(
    scheduler: Scheduler,
    selector: selectors.BaseSelector,
    real: Callable[[float | None], Ready],
    timeout: float | None,
) -> Ready:
    """Return what a selector finds ready, after at most `timeout` virtual seconds.

    `real` asks it, and waits in real time.
    """
    if scheduler.current is None:
        return real(timeout)
    if timeout is not None and timeout <= 0:
        scheduler.count_call(POLL_COST)
        return real(0)
    # Rounded up: a loop that wakes a nanosecond early finds nothing due and polls again.
    timeout_ns = None if timeout is None else max(1, math.ceil(timeout * NANOSECONDS))
    descriptors = tuple(key.fd for key in selector.get_map().values())
    scheduler.wait_until(
        lambda: bool(real(0)),
        timeout_ns=timeout_ns,
        reason="an event of its loop",
        awaited=Awaited(None, descriptors, timeout, may_answer=True) if descriptors else None,
    )
    return real(0)


def select_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    """Yield owner, name and value of what the kinds of selectors wait by that are named.

    Servers name them, and `subprocess` waits by one for the pipes of a program.
    """
    for kind in (selectors.SelectSelector, getattr(selectors, "PollSelector", None)):
        if kind is not None:
            yield kind, "select", _by_virtual_time(scheduler, kind.select)


def _by_virtual_time(scheduler: Scheduler, real: Callable[..., Ready]) -> Callable[..., Ready]:
    @functools.wraps(real)
    def select(self: Any, timeout: float | None = None) -> Ready:
        wait = functools.partial(real, self)
        if not _has_socket(self) and not may_answer(scheduler):
            return wait(timeout)
        return selected(scheduler, self, wait, timeout)

    return select


def _has_socket(selector: selectors.BaseSelector) -> bool:
    return any(stat.S_ISSOCK(os.fstat(key.fd).st_mode) for key in selector.get_map().values())
