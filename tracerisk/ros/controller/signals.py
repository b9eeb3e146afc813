"""Signals that a controller sends itself, and who handles them.

One that comes from outside ends the run as it would end any process; it is none of these.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any


class Signals:
    """The handlers of the controller's process, and what libraries in C do before them.

    A library in C that takes a signal passes it on to the handler of Python; a handler that the
    program sets later takes its place.
    """

    def __init__(self) -> None:
        self._handlers: dict[int, Any] = {}
        self._of_library: dict[int, Callable[[], None]] = {}

    def handler(self, number: int) -> Any:
        """Return the handler of Python, as `signal.getsignal` does."""
        return self._handlers.get(number, _real_getsignal(number))

    def set_handler(self, number: int, handler: Any) -> Any:
        """Take a handler of Python, and return the one before."""
        before = self.handler(number)
        self._handlers[number] = handler
        self._of_library.pop(number, None)
        return before

    def take_first(self, number: int, act: Callable[[], None] | None) -> None:
        """Call `act` at a signal before the handler of Python does anything; None: no longer."""
        if act is None:
            self._of_library.pop(number, None)
        else:
            self._of_library[number] = act

    def taken_by(self, number: int) -> Callable[[], None] | None:
        """Return what a library in C does at a signal, if any does."""
        return self._of_library.get(number)


_real_getsignal = signal.getsignal
