"""Guard conditions: callbacks that the program itself asks for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._entity import Call, Entity
from .callback_groups import CallbackGroup
from .executors import await_or_execute


class GuardCondition(Entity):
    """Calls back once for each time that it was triggered; made by `create_guard_condition`."""

    def __init__(
        self, node: Any, callback: Callable[..., Any] | None, callback_group: CallbackGroup
    ) -> None:
        super().__init__(node, callback_group)
        self.callback = callback
        self._is_triggered = False

    def trigger(self) -> None:
        """Call the callback.

        Raises:
            InvalidHandle: the condition was destroyed.
        """
        with self.handle:
            pass
        self._is_triggered = True

    def _is_ready(self) -> bool:
        return self._is_triggered

    def _take(self, executor: Any) -> Call | None:
        self._is_triggered = False

        async def call() -> None:
            callback: Any = self.callback
            await await_or_execute(callback)

        return call
