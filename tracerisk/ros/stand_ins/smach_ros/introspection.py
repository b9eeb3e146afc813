"""What shows a state machine to the SMACH viewer; nobody looks."""

from __future__ import annotations

from typing import Any


class IntrospectionServer:
    """Offers a view of a container, which changes nothing."""

    def __init__(self, server_name: str, state: Any, path: str) -> None:
        """Take what is to be shown."""

    def start(self) -> None:
        """Begin to offer it."""

    def stop(self) -> None:
        """End that."""
