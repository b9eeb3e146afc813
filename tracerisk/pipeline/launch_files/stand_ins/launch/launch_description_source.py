"""`launch.launch_description_source`: where an included description comes from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of


class LaunchDescriptionSource:
    """A launch file of any kind, or a description."""

    def __init__(
        self, launch_description: Any = None, location: Any = "", method: str = ""
    ) -> None:
        self.description = launch_description
        self._location = location
        self.method = method

    @property
    def location(self) -> Any:
        """Where the file is."""
        return self._location

    def get_launch_description(self, context: Any) -> Any:
        """Return the description that was given, or that of the file.

        Raises:
            RuntimeError: there is neither.
        """
        if self.description is not None:
            return self.description
        path = self.path(context)
        if path is None or not path.is_file():
            raise RuntimeError(f"no launch description was given, and none is at '{path}'")
        return context.read_file(path, context)

    def path(self, context: Any) -> Path | None:
        """Return the path of the file, None where a description was given."""
        return None if self.description is not None else Path(text_of(context, self._location))
