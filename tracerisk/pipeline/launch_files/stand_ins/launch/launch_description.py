"""`launch.launch_description`: a list of entities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


class LaunchDescriptionEntity:
    """Base of all that a description holds."""

    def visit(self, context: Any) -> Any:
        """Return the entities to visit next, or None."""
        return None

    def describe(self) -> str:
        """Return a text that names the entity."""
        return type(self).__name__


class LaunchDescription(LaunchDescriptionEntity):
    """What a launch file describes."""

    def __init__(
        self,
        initial_entities: Iterable[Any] | None = None,
        *,
        deprecated_reason: str | None = None,
    ) -> None:
        self.__entities = list(initial_entities or ())
        self.deprecated_reason = deprecated_reason

    @property
    def entities(self) -> list[Any]:
        """The entities."""
        return self.__entities

    def add_entity(self, entity: Any) -> None:
        """Add an entity at the end."""
        self.__entities.append(entity)

    def add_action(self, action: Any) -> None:
        """Add an action at the end."""
        self.add_entity(action)

    def visit(self, context: Any) -> Any:
        """Return the entities."""
        return [each for each in self.__entities if each is not None]
