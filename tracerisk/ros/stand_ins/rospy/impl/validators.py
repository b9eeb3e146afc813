"""What is wrong with an argument, and the check that one was given."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class ParameterInvalid(Exception):
    """An argument is not what it must be."""


def non_empty(param_name: str) -> Callable[[Any, str], Any]:
    """Return a check that raises ParameterInvalid for an empty argument."""

    def validator(param: Any, context: str) -> Any:
        if not param:
            raise ParameterInvalid(
                f"ERROR: parameter [{param_name}] must be specified and non-empty"
            )
        return param

    return validator
