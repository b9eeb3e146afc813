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

    def describe_sub_entities(self) -> list[Any]:
        """Return the entities that are visited with this one in any case."""
        return []

    def describe_conditional_sub_entities(self) -> list[tuple[str, list[Any]]]:
        """Return the entities that may be visited with this one, each list with its condition."""
        return []

    def get_asyncio_future(self) -> None:
        """Return None: nothing goes on while a description is read."""

    def _gather_arguments(self, is_conditional: bool, found: list[Any]) -> None:
        """Add the arguments that are declared below this entity."""
        below = [(is_conditional, self.describe_sub_entities())]
        below += [(True, more) for _, more in self.describe_conditional_sub_entities()]
        for within, entities in below:
            for entity in entities:
                if isinstance(entity, LaunchDescriptionEntity):
                    conditional = within or getattr(entity, "condition", None) is not None
                    entity._gather_arguments(conditional, found)


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

    @property
    def deprecated(self) -> bool:
        """Whether somebody should use another one."""
        return self.deprecated_reason is not None

    def get_launch_arguments(self) -> list[Any]:
        """Return the arguments that the description declares, those of what it includes too."""
        launch_arguments: list[Any] = []
        self._gather_arguments(False, launch_arguments)
        return launch_arguments

    def describe_sub_entities(self) -> list[Any]:
        """Return the entities."""
        return [entity for entity in self.__entities if entity is not None]

    def visit(self, context: Any) -> Any:
        """Return the entities."""
        return [entity for entity in self.__entities if entity is not None]
