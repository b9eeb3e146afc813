"""What an executor runs the callbacks of: base of timers, subscriptions and the like."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, ClassVar

from tracerisk.ros.controller.thread import Meaning

from ._handle import Handle
from ._run import run
from .callback_groups import CallbackGroup

Call = Callable[[], Coroutine[Any, Any, None]]


class Entity:
    """Something of a node that has work from time to time.

    `_is_taken`: a task for its work exists that has not begun.
    """

    _root_kind: ClassVar[str] = "callback"

    def __init__(self, node: Any, callback_group: CallbackGroup) -> None:
        self._node = node
        self.handle = Handle()
        self.callback_group = callback_group
        self._is_taken = False
        self._is_destroyed = False
        callback_group.add_entity(self)

    def _is_ready(self) -> bool:
        raise NotImplementedError

    def _take(self, executor: Any) -> Call | None:
        """Take the work out, and return what does it."""
        raise NotImplementedError

    def _meaning_of_answer(self) -> Meaning:
        """Return what it means that a thread waits for what completes a future of the entity's."""
        return Meaning("unmet", self._node._meaning_of_wait().why)

    @property
    def _is_left_lying(self) -> bool:
        """Whether work lies here, and no thread but the calling one spins the node."""
        executor = self._node.executor
        is_spun = (
            executor is not None
            and self._node in executor._nodes
            and executor._is_spun_beside(run().scheduler.current)
        )
        return self._is_ready() and not is_spun

    def destroy(self) -> None:
        """Stop working."""
        self._is_destroyed = True
        self.handle.destroy_when_not_in_use()
