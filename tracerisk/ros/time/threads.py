"""Locks and threads under the baton, in the place of those of `_thread`.

The classes of `threading`, `queue` and `concurrent.futures` are written on these few; they work
unchanged on top of them. Each of ours is also a real one, for threads that are not the
controller's and for what is left when the run is over.
"""

from __future__ import annotations

import threading
from _thread import allocate_lock, start_new_thread
from collections.abc import Callable, Mapping
from sys import _getframe
from typing import Any, NoReturn

from tracerisk.ros.controller.frames import is_quiet, poller
from tracerisk.ros.controller.thread import ControllerThread
from tracerisk.ros.time.scheduler import Scheduler

NANOSECONDS = 1_000_000_000


def nanoseconds(seconds: float) -> int:
    """Return seconds as integer nanoseconds, rounded."""
    return round(seconds * NANOSECONDS)


def for_controller(
    scheduler: Scheduler, ours: Callable[..., Any], real: Callable[..., Any]
) -> Callable[..., Any]:
    """Return what calls `ours` in a thread of the controller, and `real` in any other."""

    def either(*args: Any, **kwargs: Any) -> Any:
        return (ours if scheduler.current is not None else real)(*args, **kwargs)

    return either


class Lock:
    """A lock that its waiters wait for in virtual time."""

    __slots__ = ("__weakref__", "_holder", "_inner", "_scheduler")

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._inner = allocate_lock()
        self._holder: ControllerThread | None = None

    @property
    def holder(self) -> ControllerThread | None:
        """The thread that acquired it last, while it is held."""
        return self._holder if self._inner.locked() else None

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Acquire the lock; see `threading.Lock.acquire`."""
        if not blocking and timeout != -1:
            raise ValueError("can't specify a timeout for a non-blocking call")
        if timeout < 0 and timeout != -1:
            raise ValueError("timeout value must be a non-negative number")
        if timeout > threading.TIMEOUT_MAX:
            raise OverflowError("timeout value is too large")
        scheduler = self._scheduler
        thread = scheduler.current
        if self._inner.acquire(False):
            self._holder = thread
            scheduler.count_call()
            return True
        if thread is None:
            return self._inner.acquire(blocking, timeout)
        if not blocking:
            if not is_quiet(poller(_getframe(1))):
                scheduler.touch()
        else:
            # A condition's waiter acquires its lock twice: held by itself, freed by another.
            waits_to_be_notified = _caller_is(threading.Condition.wait)
            if not scheduler.wait_until(
                lambda: not self._inner.locked(),
                timeout_ns=None if timeout == -1 else nanoseconds(timeout),
                reason="a notification" if waits_to_be_notified else "a lock",
                on=None if waits_to_be_notified else self,
            ):
                return False
        if self._inner.acquire(False):
            self._holder = thread
            return True
        return False

    def release(self) -> None:
        """Release the lock, whoever holds it."""
        self._inner.release()

    def locked(self) -> bool:
        """Return whether the lock is held."""
        return self._inner.locked()

    acquire_lock = acquire
    release_lock = release
    locked_lock = locked

    def _is_owned(self) -> bool:
        # `Condition` else tries to acquire the lock, which would count as a poll.
        return self._inner.locked()

    def _at_fork_reinit(self) -> None:
        self._inner = allocate_lock()

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *error: object) -> None:
        self.release()

    def __reduce__(self) -> NoReturn:
        raise TypeError("cannot pickle '_thread.lock' object")

    def __repr__(self) -> str:
        state = "locked" if self.locked() else "unlocked"
        return f"<{state} _thread.lock object at {id(self):#x}>"


def _caller_is(function: Callable[..., object]) -> bool:
    return _getframe(2).f_code is function.__code__


class ThreadStarter:
    """Starts threads under the baton when a thread of the controller asks, else real ones."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler

    def allocate_lock(self) -> Any:
        """Make a lock: a virtual one for the controller."""
        return Lock(self._scheduler) if self._scheduler.current is not None else allocate_lock()

    def start_new_thread(
        self,
        function: Callable[..., object],
        args: tuple[Any, ...],
        kwargs: Mapping[str, Any] | None = None,
        /,
    ) -> int:
        """Start a thread; see `_thread.start_new_thread`."""
        if self._scheduler.current is None:
            return start_new_thread(function, args, dict(kwargs or {}))
        name, daemon = getattr(function, "__name__", "thread"), True
        started = getattr(function, "__self__", None)
        if isinstance(started, threading.Thread):
            name, daemon = started.name, started.daemon
        thread = self._scheduler.spawn(
            lambda: function(*args, **(kwargs or {})), name, daemon=daemon
        )
        return thread.ident or 0

    def set_sentinel(self, real: Callable[[], Any]) -> Any:
        """Make the lock that is released when the calling thread ends (CPython up to 3.12)."""
        thread = self._scheduler.current
        if thread is None:
            return real()
        sentinel = _Sentinel(self._scheduler, thread)
        thread.at_finish.append(sentinel.thread_has_ended)
        return sentinel

    def start_joinable_thread(
        self, real: Callable[..., Any], function: Callable[[], object], handle: Any, daemon: bool
    ) -> Any:
        """Start a thread that `handle` waits for (CPython from 3.13)."""
        if not isinstance(handle, ThreadHandle):
            return real(function, handle=handle, daemon=daemon)
        started = getattr(function, "__self__", None)
        name = started.name if isinstance(started, threading.Thread) else "thread"
        handle.thread = self._scheduler.spawn(function, name, daemon=daemon)
        return handle


class _Sentinel(Lock):
    """Held while a thread lives; who waits for it waits for that thread."""

    __slots__ = ("_thread",)

    def __init__(self, scheduler: Scheduler, thread: ControllerThread) -> None:
        super().__init__(scheduler)
        self._thread = thread

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Acquire the lock: at once in the thread itself, else when that has ended."""
        thread = self._scheduler.current
        if thread is None or thread is self._thread or not blocking or timeout == 0:
            return super().acquire(blocking, timeout)
        ended = self._scheduler.wait_until(
            lambda: not self.locked(),
            timeout_ns=None if timeout == -1 else nanoseconds(timeout),
            reason=f"the end of thread {self._thread.name}",
            on=self._thread,
        )
        return ended and super().acquire(False)

    def thread_has_ended(self) -> None:
        """Wake those who joined the thread."""
        if self.locked():
            self.release()


class ThreadHandle:
    """What `threading.Thread` of CPython 3.13 keeps of a thread that it started."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._done = False
        self.thread: ControllerThread | None = None

    @property
    def ident(self) -> int | None:
        """The identifier of the real thread."""
        return self.thread.ident if self.thread is not None else None

    def is_done(self) -> bool:
        """Return whether the thread has ended."""
        return self._done or (self.thread is not None and self.thread.finished)

    def _set_done(self) -> None:
        self._done = True

    def join(self, timeout: float | None = None) -> None:
        """Wait until the thread has ended."""
        thread = self.thread
        if thread is None or self.is_done() or self._scheduler.current is None:
            return
        self._scheduler.wait_until(
            lambda: thread.finished,
            timeout_ns=None if timeout is None or timeout < 0 else nanoseconds(timeout),
            reason=f"the end of thread {thread.name}",
            on=thread,
        )
