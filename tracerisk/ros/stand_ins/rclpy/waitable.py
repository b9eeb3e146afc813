"""What an executor asks for work beside the entities that it knows."""

from __future__ import annotations

from typing import Any

from ._entity import Call, Entity
from .callback_groups import CallbackGroup

__all__ = ["NumberOfEntities", "Waitable"]

_KINDS = ("subscriptions", "guard_conditions", "timers", "clients", "services", "events")


class NumberOfEntities:
    """How many entities of each kind something is made of."""

    __slots__ = tuple(f"num_{kind}" for kind in _KINDS)

    num_subscriptions: int
    num_guard_conditions: int
    num_timers: int
    num_clients: int
    num_services: int
    num_events: int

    def __init__(
        self,
        num_subs: int = 0,
        num_gcs: int = 0,
        num_timers: int = 0,
        num_clients: int = 0,
        num_services: int = 0,
        num_events: int = 0,
    ) -> None:
        counts = (num_subs, num_gcs, num_timers, num_clients, num_services, num_events)
        for name, count in zip(self.__slots__, counts, strict=True):
            setattr(self, name, count)

    def __add__(self, other: NumberOfEntities) -> NumberOfEntities:
        return NumberOfEntities(
            *(getattr(self, name) + getattr(other, name) for name in self.__slots__)
        )

    def __repr__(self) -> str:
        text = ", ".join(str(getattr(self, name)) for name in self.__slots__)
        return f"{type(self).__name__}({text})"


class Waitable(Entity):
    """Base of what a program asks an executor to look after; see `Node.add_waitable`.

    Nothing is put into a wait set: there is none here, so that None stands for it. The executor
    asks `is_ready` whenever something has happened.
    """

    def __init__(self, callback_group: CallbackGroup) -> None:
        super().__init__(None, callback_group)
        self._was_added = False

    def __enter__(self) -> None:
        """Mark what it is made of as in use."""

    def __exit__(self, *error: object) -> None:
        """Mark it as in use no longer."""

    def add_future(self, future: Any) -> None:
        """Take a future that is completed by this; nothing has to be done for it."""

    def remove_future(self, future: Any) -> None:
        """Forget such a future."""

    def is_ready(self, wait_set: Any) -> bool:
        """Return whether there is work."""
        raise NotImplementedError("Must be implemented by subclass")

    def take_data(self) -> Any:
        """Take out what the work is done with."""
        raise NotImplementedError("Must be implemented by subclass")

    async def execute(self, taken_data: Any) -> None:
        """Do the work with what was taken."""
        raise NotImplementedError("Must be implemented by subclass")

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities of each kind it is made of."""
        raise NotImplementedError("Must be implemented by subclass")

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Add the entities to what the executor waits for."""
        raise NotImplementedError("Must be implemented by subclass")

    def _is_ready(self) -> bool:
        if not self._was_added:
            self._was_added = True
            self.add_to_wait_set(None)
        return bool(self.is_ready(None))

    def _take(self, executor: Any) -> Call | None:
        taken = self.take_data()

        async def call() -> None:
            await self.execute(taken)

        return call
