"""`launch.condition`: whether an action is done."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Condition:
    """Holds where its predicate does; without one it does not hold."""

    def __init__(self, *, predicate: Callable[[Any], bool] | None = None) -> None:
        self._predicate = predicate

    def evaluate(self, context: Any) -> bool:
        """Return whether it holds."""
        return self._predicate is not None and self._predicate(context)

    def describe(self) -> str:
        """Return a text that names the condition."""
        return type(self).__name__
