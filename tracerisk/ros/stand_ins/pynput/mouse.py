"""Stand-in for pynput.mouse: nobody moves a mouse."""

from __future__ import annotations

import enum
import threading
from typing import Any

__all__ = ["Button", "Listener"]


class Button(enum.Enum):
    """A button of a mouse."""

    unknown = 0
    left = 1
    middle = 2
    right = 3


class Listener(threading.Thread):
    """A thread that hears nothing until it is stopped."""

    def __init__(self, *_: Any, **__: Any) -> None:
        super().__init__(daemon=True)
        self._stopped = threading.Event()

    @property
    def running(self) -> bool:
        """Whether it listens."""
        return self.is_alive() and not self._stopped.is_set()

    def run(self) -> None:
        """Wait to be stopped."""
        self._stopped.wait()

    def stop(self) -> None:
        """Listen no more."""
        self._stopped.set()

    def wait(self) -> None:
        """Return when it listens, at once."""

    def __enter__(self) -> Listener:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
