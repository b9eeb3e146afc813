"""Which callbacks may run while others do."""

from __future__ import annotations

from typing import Any


class CallbackGroup:
    """Base of the groups; an executor asks one before it runs a callback of its entities."""

    def __init__(self) -> None:
        self.entities: list[Any] = []

    def add_entity(self, entity: Any) -> None:
        """Take an entity into the group."""
        if entity not in self.entities:
            self.entities.append(entity)

    def has_entity(self, entity: Any) -> bool:
        """Return whether an entity is of the group."""
        return entity in self.entities

    def can_execute(self, entity: Any) -> bool:
        """Return whether the entity's callback may run now."""
        raise NotImplementedError

    def beginning_execution(self, entity: Any) -> bool:
        """Note that the entity's callback begins, and return whether it may."""
        raise NotImplementedError

    def ending_execution(self, entity: Any) -> None:
        """Note that the entity's callback has ended."""
        raise NotImplementedError


class ReentrantCallbackGroup(CallbackGroup):
    """Any number of callbacks at once, the same one too."""

    def can_execute(self, entity: Any) -> bool:
        """Return True."""
        return True

    def beginning_execution(self, entity: Any) -> bool:
        """Return True."""
        return True

    def ending_execution(self, entity: Any) -> None:
        """Note nothing."""


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """One callback at a time, until it has returned; one that awaits has not."""

    def __init__(self) -> None:
        super().__init__()
        self._active: Any = None

    def can_execute(self, entity: Any) -> bool:
        """Return whether no callback of the group runs."""
        return self._active is None

    def beginning_execution(self, entity: Any) -> bool:
        """Note that the entity's callback begins, if none of the group runs."""
        if self._active is not None:
            return False
        self._active = entity
        return True

    def ending_execution(self, entity: Any) -> None:
        """Note that the entity's callback has ended."""
        if self._active is not entity:
            raise RuntimeError("the callback that ends is not the one that runs")
        self._active = None
