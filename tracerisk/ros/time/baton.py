"""What the controller's threads are made of, and how one hands the baton to another."""

from __future__ import annotations

from _thread import allocate_lock, get_ident, start_new_thread
from collections.abc import Callable, Iterator
from typing import Any, NoReturn, Protocol

from tracerisk.ros.controller.thread import ControllerThread


class Baton(Protocol):
    """Runs one thread of the controller at a time: the one that was handed the baton."""

    def ident(self) -> int:
        """Return the identifier of what runs: a thread of the controller, or another thread."""

    def take(self, thread: ControllerThread) -> int:
        """Give the calling thread the baton, as the first; return its identifier."""

    def start(self, thread: ControllerThread, run: Callable[[], None]) -> int:
        """Make a thread that does `run` when it is first handed the baton; return its identifier.

        `run` ends with `leave`.
        """

    def hand(self, thread: ControllerThread, following: ControllerThread) -> None:
        """Hand the baton on, and return when `thread`, which calls this, has it again."""

    def hand_for_good(self, thread: ControllerThread, following: ControllerThread) -> NoReturn:
        """Hand the baton on; `thread`, which calls this, never gets it again."""

    def leave(self, thread: ControllerThread, following: ControllerThread) -> None:
        """Hand the baton on as the last act of `thread`, which calls this."""

    def replacements(self) -> Iterator[tuple[Any, str, Any]]:
        """Yield owner, name and value of what must be replaced process-wide for it."""


class ThreadBaton:
    """Real threads, each of which waits at a lock of its own."""

    def ident(self) -> int:
        """Return the identifier of the thread that runs."""
        return get_ident()

    def take(self, thread: ControllerThread) -> int:
        """Give the calling thread the baton."""
        self._close(thread)
        return get_ident()

    def start(self, thread: ControllerThread, run: Callable[[], None]) -> int:
        """Start a thread that waits for the baton."""
        self._close(thread)

        def begin() -> None:
            self._wait(thread)
            run()

        return start_new_thread(begin, ())

    def hand(self, thread: ControllerThread, following: ControllerThread) -> None:
        """Open the gate of the other thread, and wait at one's own."""
        following.gate.release()
        self._wait(thread)

    def hand_for_good(self, thread: ControllerThread, following: ControllerThread) -> NoReturn:
        """Open the gate of the other thread; what waits here dies with the process."""
        following.gate.release()
        while True:
            thread.gate.acquire()

    def leave(self, thread: ControllerThread, following: ControllerThread) -> None:  # noqa: ARG002
        """Open the gate of the other thread."""
        following.gate.release()

    def replacements(self) -> Iterator[tuple[Any, str, Any]]:
        """Yield nothing: these are the threads that Python knows."""
        yield from ()

    @staticmethod
    def _close(thread: ControllerThread) -> None:
        thread.gate = allocate_lock()
        thread.gate.acquire()

    @staticmethod
    def _wait(thread: ControllerThread) -> None:
        while True:
            try:
                thread.gate.acquire()
            except BaseException as error:  # noqa: BLE001 - a signal's; raised with the baton
                thread.interrupt = error
            else:
                return
