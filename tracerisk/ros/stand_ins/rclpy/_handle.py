"""What stands for a thing of the middleware: it is good until the thing is destroyed."""

from __future__ import annotations

from .exceptions import InvalidHandle

GONE = "cannot use Destroyable because destruction was requested"


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
