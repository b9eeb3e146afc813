"""`launch.conditions`."""

from __future__ import annotations

import warnings
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.condition import Condition
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of

_TRUE, _FALSE = ("true", "1"), ("false", "0")


class InvalidConditionExpressionError(Exception):
    """A condition's text says neither true nor false."""


def evaluate_condition_expression(context: Any, expression: Any) -> bool:
    """Return what a text says: true, 1, false or 0.

    Raises:
        InvalidConditionExpressionError: it says neither.
    """
    text = text_of(context, expression).strip().lower()
    if text in _TRUE:
        return True
    if text in _FALSE:
        return False
    raise InvalidConditionExpressionError(
        f"invalid condition expression '{text}', expected true, 1, false or 0"
    )


class IfCondition(Condition):
    """Holds where a text says true."""

    def __init__(self, predicate_expression: Any) -> None:
        self.__expression = predicate_expression
        super().__init__(predicate=self._holds)

    def _holds(self, context: Any) -> bool:
        return evaluate_condition_expression(context, self.__expression)


class UnlessCondition(Condition):
    """Holds where a text says false."""

    def __init__(self, predicate_expression: Any) -> None:
        self.__expression = predicate_expression
        super().__init__(predicate=self._holds)

    def _holds(self, context: Any) -> bool:
        return not evaluate_condition_expression(context, self.__expression)


class LaunchConfigurationEquals(Condition):
    """Holds where a launch configuration has a value, or is not set and None is expected."""

    def __init__(self, launch_configuration_name: str, expected_value: Any) -> None:
        warnings.warn(
            f"The '{type(self).__name__}' condition is deprecated: use an IfCondition with an "
            "EqualsSubstitution",
            UserWarning,
            stacklevel=2,
        )
        self.__name = launch_configuration_name
        self.__expected = expected_value
        super().__init__(predicate=self._holds)

    def _holds(self, context: Any) -> bool:
        value = context.launch_configurations.get(self.__name)
        if self.__expected is None or value is None:
            return value is None and self.__expected is None
        return bool(value == text_of(context, self.__expected))


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """Holds where a launch configuration has another value."""

    def _holds(self, context: Any) -> bool:
        return not super()._holds(context)
