"""What a controller that starts the probe finds in a run on the twin, which records by itself."""

from typing import Any


def start(*args: Any, **kwargs: Any) -> None:
    """Do nothing."""


def watch(function: Any, name: str = "", type: str = "") -> Any:
    """Return the function as it is."""
    return function
