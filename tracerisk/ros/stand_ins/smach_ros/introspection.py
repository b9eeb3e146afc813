"""What shows a state machine to the SMACH viewer; nobody looks."""

from __future__ import annotations

from typing import Any


class IntrospectionServer:
    """Offers a view of a container, which changes nothing."""

    def __init__(self, server_name: str, state: Any, path: str) -> None:
        self._server_name, self._state, self._path = server_name, state, path

    def start(self) -> None:
        """Begin to offer it."""

    def stop(self) -> None:
        """End that."""
