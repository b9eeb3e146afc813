"""Listen to what Python reports to audit hooks, through one hook however many listen.

Python calls each hook at each event, and thousands of them concern nobody: attributes of frames.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import Any

Listener = Callable[[str, tuple[Any, ...]], None]
"""Called with the name of an event and its arguments."""

_LISTENERS: dict[str, tuple[Listener, ...]] = {}
"""Who listens to an event. A hook cannot be removed: it is of the process, and so is this."""


def listen(events: Iterable[str], listener: Listener) -> None:
    """Call a function at each of the events from now on, until the process ends."""
    if not _LISTENERS:
        sys.addaudithook(_heard)
    for event in events:
        _LISTENERS[event] = (*_LISTENERS.get(event, ()), listener)


def _heard(event: str, arguments: tuple[Any, ...]) -> None:
    if event in _LISTENERS:
        for listener in _LISTENERS[event]:
            listener(event, arguments)
