"""`launch.launch_service`: starts nothing here."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


class LaunchIntrospector:
    """Lists what a description holds."""

    def format_launch_description(self, launch_description: Any) -> str:
        """Return a line for each entity."""
        return "\n".join(entity.describe() for entity in launch_description.entities)


class LaunchService:
    """Takes descriptions; to run them is refused."""

    def __init__(
        self,
        *,
        argv: Iterable[str] | None = None,
        noninteractive: bool = False,
        debug: bool = False,
    ) -> None:
        self.descriptions: list[Any] = []

    def include_launch_description(self, launch_description: Any) -> None:
        """Take a description."""
        self.descriptions.append(launch_description)

    def run(self, *, shutdown_when_idle: bool = True) -> int:
        """Refuse to start anything."""
        raise RuntimeError("launch.LaunchService.run: launch files are read here, not started")
