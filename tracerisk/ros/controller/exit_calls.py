"""What is called when the controller's main thread has ended by itself."""

from __future__ import annotations

import traceback
from collections.abc import Callable


class ExitCalls:
    """Calls before the other threads are joined, and, as of `atexit`, calls after that."""

    def __init__(self) -> None:
        self._before_joining: list[Callable[[], object]] = []
        self._at_exit: list[tuple[object, Callable[[], object]]] = []

    def at_main_end(self, callback: Callable[[], object]) -> None:
        """Run `callback` before others are joined; it must raise nothing."""
        self._before_joining.append(callback)

    def at_exit(self, callback: Callable[[], object], key: object = None) -> None:
        """Run `callback` after the others are joined; the last one first."""
        self._at_exit.append((callback if key is None else key, callback))

    def forget(self, key: object) -> None:
        """Take back every call at exit that was given under `key`, by default itself."""
        self._at_exit = [call for call in self._at_exit if call[0] != key]

    def run_before_joining(self) -> None:
        """Run the calls before the other threads are joined."""
        for callback in self._before_joining:
            callback()

    def run_at_exit(self) -> None:
        """Run the calls at exit, and those that they add."""
        while self._at_exit:
            _, callback = self._at_exit.pop()
            try:
                callback()
            except Exception:  # noqa: BLE001 - the controller's; CPython prints it and goes on
                traceback.print_exc()
