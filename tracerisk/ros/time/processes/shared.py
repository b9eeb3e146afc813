"""What processes share and wait for: queues, pipes, values, a manager."""

from __future__ import annotations

import pickle
import queue
import threading
import types
from multiprocessing import sharedctypes
from typing import Any

from tracerisk.ros.time.processes.pool import ProcessPool


def _copied(value: Any) -> Any:
    """Return what another process would get; the object itself where pickle cannot take it."""
    try:
        return pickle.loads(pickle.dumps(value))
    except Exception:  # noqa: BLE001 - whatever a class raises when it is pickled
        return value


class ProcessQueue(queue.Queue[Any]):
    """A queue between processes: what goes in is copied."""

    def put(self, item: Any, block: bool = True, timeout: float | None = None) -> None:
        """Put a copy; see `queue.Queue.put`."""
        super().put(_copied(item), block, timeout)

    def close(self) -> None:
        """Do nothing: what was put is there."""

    def join_thread(self) -> None:
        """Do nothing: there is no thread that feeds a pipe."""

    def cancel_join_thread(self) -> None:
        """Do nothing: there is no thread that feeds a pipe."""


_CLOSED = object()


class _Connection:
    """One end of a pipe between processes."""

    def __init__(self, inbox: queue.Queue[Any] | None, outbox: queue.Queue[Any] | None) -> None:
        self._inbox, self._outbox = inbox, outbox
        self._at_end = False
        self.closed = False
        self.readable, self.writable = inbox is not None, outbox is not None

    def send(self, item: Any) -> None:
        """Send a copy of an object."""
        self._require(self._outbox, "read-only").put(_copied(item))

    def recv(self) -> Any:
        """Wait for the next object; raises EOFError where the other end is closed."""
        inbox = self._require(self._inbox, "write-only")
        item = _CLOSED if self._at_end else inbox.get()
        if item is _CLOSED:
            self._at_end = True
            raise EOFError
        return item

    send_bytes, recv_bytes = send, recv

    def poll(self, timeout: float | None = 0.0) -> bool:
        """Return whether there is something to receive, waiting at most `timeout` [s]."""
        inbox = self._require(self._inbox, "write-only")
        if self._at_end or not inbox.empty():
            return True
        if timeout is not None and timeout <= 0.0:
            return False
        with inbox.not_empty:
            return inbox.not_empty.wait_for(lambda: bool(inbox.queue), timeout)

    def close(self) -> None:
        """Close this end; the other then receives EOFError behind what was sent."""
        if not self.closed and self._outbox is not None:
            self._outbox.put(_CLOSED)
        self.closed = True

    def _require(self, box: queue.Queue[Any] | None, other: str) -> queue.Queue[Any]:
        if self.closed:
            raise OSError("handle is closed")
        if box is None:
            raise OSError(f"connection is {other}")
        return box

    def __enter__(self) -> _Connection:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def pipe(duplex: bool = True) -> tuple[_Connection, _Connection]:
    """Return the two ends of a pipe; not `duplex`, the first receives and the second sends."""
    forth: queue.Queue[Any] = queue.Queue()
    if not duplex:
        return _Connection(forth, None), _Connection(None, forth)
    back: queue.Queue[Any] = queue.Queue()
    return _Connection(back, forth), _Connection(forth, back)


class Manager:
    """A manager, whose objects need no server: all processes see the same."""

    def __init__(self) -> None:
        self.dict, self.list, self.Namespace = dict, list, types.SimpleNamespace
        self.Queue, self.JoinableQueue, self.Pool = ProcessQueue, ProcessQueue, ProcessPool
        self.Value, self.Array = value, array
        self.Lock, self.RLock, self.Event = threading.Lock, threading.RLock, threading.Event
        self.Condition, self.Semaphore = threading.Condition, threading.Semaphore
        self.BoundedSemaphore, self.Barrier = threading.BoundedSemaphore, threading.Barrier

    def start(self) -> None:
        """Do nothing: there is no server to start."""

    def shutdown(self) -> None:
        """Do nothing: there is no server to end."""

    def __enter__(self) -> Manager:
        return self

    def __exit__(self, *error: object) -> None:
        """Do nothing, as `shutdown`."""


def value(kind: Any, *args: Any, lock: Any = True) -> Any:
    """Return a shared value; see `multiprocessing.Value`."""
    made = _c_type(kind)(*args)
    return made if lock is False else sharedctypes.synchronized(made, _lock_of(lock))


def array(kind: Any, size_or_values: Any, *, lock: Any = True) -> Any:
    """Return a shared array; see `multiprocessing.Array`."""
    each = _c_type(kind)
    if isinstance(size_or_values, int):
        made = (each * size_or_values)()
    else:
        values = list(size_or_values)
        made = (each * len(values))(*values)
    return made if lock is False else sharedctypes.synchronized(made, _lock_of(lock))


def _c_type(kind: Any) -> Any:
    return vars(sharedctypes)["typecode_to_type"].get(kind, kind)


def _lock_of(lock: Any) -> Any:
    return threading.RLock() if lock in (True, None) else lock
