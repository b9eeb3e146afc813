"""What stands for a thing of the middleware: it is good until the thing is destroyed."""

from __future__ import annotations

from typing import Any

from ._rclpy_pybind11 import RCLError
from .exceptions import InvalidHandle

GONE = "cannot use Destroyable because destruction was requested"


OF_CONTEXT = (
    "the given context is not valid, either rcl_init() was not called or rcl_shutdown() was called."
)
OF_NODE = "rcl node's context is invalid"
OF_PUBLISHER = "publisher's context is invalid"


def check_context(context: Any, doing: str, why: str = OF_NODE) -> None:
    """Refuse what a context that was shut down does no longer, in the words of rcl.

    Raises:
        RCLError: the context was shut down; `doing` says what failed.
    """
    if not context.is_valid:
        raise RCLError(f"{doing}: {why}")


class Handle:
    """Keeps a thing while it is used as a context manager, and refuses one that was destroyed."""

    def __init__(self) -> None:
        self._is_destroyed = False

    def destroy_when_not_in_use(self) -> None:
        """Refuse the thing to everybody from now on; who uses it goes on to the end."""
        self._is_destroyed = True

    def __enter__(self) -> Handle:
        if self._is_destroyed:
            raise InvalidHandle(GONE)
        return self

    def __exit__(self, *error: object) -> None:
        """Use the thing no longer."""
