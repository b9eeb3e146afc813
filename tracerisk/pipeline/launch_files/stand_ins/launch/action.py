"""`launch.action`: base of all actions."""

from __future__ import annotations

from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.condition import Condition
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description import (
    LaunchDescriptionEntity,
)


class Action(LaunchDescriptionEntity):
    """Something that a description does, if its condition holds."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        self.__condition = condition

    @property
    def condition(self) -> Condition | None:
        """The condition, None for none."""
        return self.__condition

    def visit(self, context: Any) -> Any:
        """Return what `execute` returns where the condition holds."""
        condition = self.__condition
        if condition is None or condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: Any) -> Any:
        """Do the action and return the entities to visit next, or None."""
        return None
