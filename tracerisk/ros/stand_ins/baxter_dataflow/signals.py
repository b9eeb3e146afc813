"""Signals: functions that are called together."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Signal:
    """Calls every function that is connected."""

    def __init__(self) -> None:
        self._slots: list[Callable[..., Any]] = []

    def __call__(self, *args: Any, **kargs: Any) -> None:
        """Call every function."""
        for slot in list(self._slots):
            slot(*args, **kargs)

    def connect(self, slot: Callable[..., Any]) -> None:
        """Add a function."""
        if slot not in self._slots:
            self._slots.append(slot)

    def disconnect(self, slot: Callable[..., Any]) -> None:
        """Take a function away."""
        if slot in self._slots:
            self._slots.remove(slot)
