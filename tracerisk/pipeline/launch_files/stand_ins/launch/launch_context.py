"""`launch.launch_context`: what holds where a description is walked through."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

from tracerisk.pipeline.launch_files.placeholders import AbsentError
from tracerisk.pipeline.launch_files.records import RobotSource, StartedNode
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution

_MOST_ENTITIES = 20_000
_DEEPEST = 200


@dataclass(slots=True)
class Reading:
    """What a walk through a description has found so far."""

    nodes: list[StartedNode] = field(default_factory=list)
    """The programs that are started."""
    sources: list[Path] = field(default_factory=list)
    """The files that were read."""
    problems: list[str] = field(default_factory=list)
    """What could not be read, in words."""
    robots: list[RobotSource] = field(default_factory=list)
    """The robot description files that were named."""


class LaunchContext:
    """Configurations, environment and namespaces, and what was found with them."""

    read_file: ClassVar[Callable[[Path, Any], Any]]
    """Returns the description that a file holds. `launch_files.visit` sets it."""

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = True) -> None:
        self.argv = list(argv or ())
        self.noninteractive = noninteractive
        self.launch_configurations: dict[str, Any] = {}
        self.environment: dict[str, str] = dict(os.environ)
        self.changed_environment: dict[str, str] = {}
        self.reading = Reading()
        self.packages: Mapping[str, Path] = {}
        self.is_shutdown = False
        self._locals: dict[str, Any] = {}
        self._scopes: list[dict[str, Any]] = []
        self._environments: list[tuple[dict[str, str], dict[str, str]]] = []
        self._handlers: list[tuple[Any, dict[str, Any], dict[str, Any]]] = []
        self._executed: dict[int, Any] = {}
        self._visited = 0
        self._depth = 0

    @property
    def locals(self) -> Any:
        """The local values as attributes."""
        return SimpleNamespace(**self._locals)

    def get_locals_as_dict(self) -> dict[str, Any]:
        """Return the local values."""
        return dict(self._locals)

    def extend_locals(self, extensions: Mapping[str, Any]) -> None:
        """Add local values."""
        self._locals.update(extensions)

    def replace_locals(self, values: Mapping[str, Any]) -> None:
        """Set the local values anew, as an included file does when it is over."""
        self._locals = dict(values)

    def perform_substitution(self, sub: Substitution) -> str:
        """Return the text of a substitution."""
        return sub.perform(self)

    def push_configurations(self) -> None:
        """Begin a scope of launch configurations."""
        self._scopes.append(dict(self.launch_configurations))

    def pop_configurations(self) -> None:
        """End a scope of launch configurations.

        Raises:
            RuntimeError: none has begun.
        """
        if not self._scopes:
            raise RuntimeError("no launch configurations were pushed")
        # In place: others hold the dictionary.
        kept = self._scopes.pop()
        self.launch_configurations.clear()
        self.launch_configurations.update(kept)

    def push_environment(self) -> None:
        """Begin a scope of environment variables."""
        self._environments.append((dict(self.environment), dict(self.changed_environment)))

    def pop_environment(self) -> None:
        """End a scope of environment variables.

        Raises:
            RuntimeError: none has begun.
        """
        if not self._environments:
            raise RuntimeError("no environment was pushed")
        self.environment, self.changed_environment = self._environments.pop()

    def set_environment(self, name: str, value: str) -> None:
        """Set an environment variable for what is started from here on."""
        self.environment[name] = self.changed_environment[name] = value

    def walk(self, entity: Any) -> None:
        """Visit an entity and all below it; what fails is a problem of the reading."""
        self._visited += 1
        if self._visited > _MOST_ENTITIES or self._depth > _DEEPEST:
            raise RecursionError("the launch file includes itself, or is far too large")
        self._depth += 1
        try:
            below = entity.visit(self)
            # Kept, so that no other entity gets its number.
            self._executed[id(entity)] = entity
            for item in below or ():
                self.walk(item)
        except (RecursionError, MemoryError):
            raise
        # Whatever a launch file of anybody raises is a finding about it.
        except Exception as error:  # noqa: BLE001
            self.problem(entity, error)
        finally:
            self._depth -= 1

    def problem(self, entity: Any, error: Exception) -> None:
        """Note what could not be evaluated, once."""
        name = entity.describe()
        reason = str(error) if isinstance(error, AbsentError) else f"{_text(error)}"
        line = f"{name}: {reason}"
        if line not in self.reading.problems:
            self.reading.problems.append(line)

    def register_event_handler(self, handler: Any, append: bool = False) -> None:
        """Keep an event's handler until all else is visited."""
        self._handlers.append((handler, dict(self.launch_configurations), dict(self._locals)))

    def unregister_event_handler(self, handler: Any) -> None:
        """Forget an event's handler."""
        self._handlers = [row for row in self._handlers if row[0] is not handler]

    def emit_event_sync(self, event: Any) -> None:
        """Do nothing: no events come while a description is read."""

    def fire_handlers(self) -> None:
        """Handle each awaited event of a target that was started."""
        is_progress = True
        while self._handlers and is_progress:
            is_progress = False
            waiting, self._handlers = self._handlers, []
            for row in waiting:
                handler, configurations, local = row
                target = getattr(handler, "target", None)
                if target is not None and id(target) not in self._executed:
                    self._handlers.append(row)
                    continue
                is_progress = True
                for name, value in configurations.items():
                    self.launch_configurations.setdefault(name, value)
                self.replace_locals({**self._locals, **local})
                for entity in handler.fired(self):
                    self.walk(entity)


def _text(error: Exception) -> str:
    text = str(error).strip().splitlines()
    return f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
