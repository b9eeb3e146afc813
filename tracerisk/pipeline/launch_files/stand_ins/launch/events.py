"""`launch.events`: none ever comes; launch files only name them."""

from __future__ import annotations

from typing import Any


class Event:
    """Base of all events."""


class Shutdown(Event):
    """The launch is to end."""

    def __init__(self, *, reason: str = "reason not given", due_to_sigint: bool = False) -> None:
        self.reason = reason
        self.due_to_sigint = due_to_sigint


class ExecutionComplete(Event):
    """An action is over."""

    def __init__(self, *, action: Any) -> None:
        self.action = action


class ProcessStarted(Event):
    """A program of a launch file runs."""

    def __init__(self, *, action: Any = None, name: str = "", pid: int = 0, **_: Any) -> None:
        self.action = action
        self.process_name = name
        self.pid = pid


class ProcessExited(ProcessStarted):
    """A program of a launch file has ended well."""

    def __init__(self, *, returncode: int = 0, **rest: Any) -> None:
        super().__init__(**rest)
        self.returncode = returncode


def matches_action(target_action: Any) -> Any:
    """Return a matcher for the events of an action."""
    return lambda event: getattr(event, "action", None) is target_action
