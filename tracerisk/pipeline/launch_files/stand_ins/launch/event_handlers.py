"""`launch.event_handlers`: each event comes once, after all else is visited."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch import events
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description import (
    LaunchDescriptionEntity,
)


class EventHandler:
    """Entities to visit, or a function to call, when an event comes."""

    def __init__(self, *, matcher: Any = None, entities: Any = None, handle_once: bool = False):
        self.matcher = matcher
        self.target: Any = None
        self._then = entities

    def event(self) -> events.Event | None:
        """Return the event that comes, None where it is not expected in a good run."""
        return events.Event()

    def fired(self, context: Any) -> list[Any]:
        """Return the entities that the event leads to."""
        event = self.event()
        if event is None or self._then is None:
            return []
        then = self._then
        if callable(then) and not isinstance(then, LaunchDescriptionEntity):
            then = then(event, context)
        if then is None:
            return []
        return [item for item in then if item is not None] if isinstance(then, Iterable) else [then]


class _OnTarget(EventHandler):
    def __init__(self, target_action: Any, then: Any, rest: dict[str, Any]) -> None:
        rest.pop("handle_once", None)
        if rest:
            raise TypeError(f"{type(self).__name__} got an unexpected argument {min(rest)}")
        super().__init__(entities=then)
        # A function that decides which programs are meant fits any.
        self.target = None if callable(target_action) else target_action


class OnProcessExit(_OnTarget):
    """When a program has ended."""

    def __init__(self, *, target_action: Any = None, on_exit: Any = None, **rest: Any) -> None:
        super().__init__(target_action, on_exit, rest)

    def event(self) -> events.Event:
        """Return that the program has ended well."""
        return events.ProcessExited(action=self.target)


class OnProcessStart(_OnTarget):
    """When a program has started."""

    def __init__(self, *, target_action: Any = None, on_start: Any = None, **rest: Any) -> None:
        super().__init__(target_action, on_start, rest)

    def event(self) -> events.Event:
        """Return that the program has started."""
        return events.ProcessStarted(action=self.target)


class OnExecutionComplete(_OnTarget):
    """When an action is over."""

    def __init__(self, *, target_action: Any = None, on_completion: Any = None, **rest: Any):
        super().__init__(target_action, on_completion, rest)

    def event(self) -> events.Event:
        """Return that the action is over."""
        return events.ExecutionComplete(action=self.target)


class OnIncludeLaunchDescription(EventHandler):
    """When a launch file was included; it has no entities of its own."""

    def __init__(self, **_: Any) -> None:
        super().__init__()


class OnProcessIO(EventHandler):
    """When a program prints: what it would print is not known, and nothing follows."""

    def __init__(
        self,
        *,
        target_action: Any = None,
        on_stdin: Any = None,
        on_stdout: Any = None,
        on_stderr: Any = None,
        **_: Any,
    ) -> None:
        super().__init__()


class OnShutdown(EventHandler):
    """When the launch ends: that is after the controller's run."""

    def __init__(self, *, on_shutdown: Any = None, **_: Any) -> None:
        super().__init__()


def event_named(event_name: str) -> Any:
    """Return a matcher for the events of a name."""
    return lambda event: getattr(event, "name", None) == event_name
