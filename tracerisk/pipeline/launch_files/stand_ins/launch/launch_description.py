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
        found: list[Any] = []
        _gather_arguments(self.__entities, False, found)
        return found

    def describe_sub_entities(self) -> list[Any]:
        """Return the entities."""
        return [each for each in self.__entities if each is not None]

    def visit(self, context: Any) -> Any:
        """Return the entities."""
        return [each for each in self.__entities if each is not None]


def _gather_arguments(entities: Iterable[Any], is_conditional: bool, found: list[Any]) -> None:
    from tracerisk.pipeline.launch_files.stand_ins.launch.actions import DeclareLaunchArgument

    for each in entities:
        within = is_conditional or getattr(each, "condition", None) is not None
        if isinstance(each, DeclareLaunchArgument):
            each._conditionally_included = within
            if each.name not in {known.name for known in found}:
                found.append(each)
        elif isinstance(each, LaunchDescriptionEntity):
            _gather_arguments(each.describe_sub_entities(), within, found)
            for _, more in each.describe_conditional_sub_entities():
                _gather_arguments(more, True, found)
