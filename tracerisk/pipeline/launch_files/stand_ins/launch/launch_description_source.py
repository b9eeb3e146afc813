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

    @property
    def location(self) -> Any:
        """Where the file is."""
        return self._location

    def path(self, context: Any) -> Path | None:
        """Return the path of the file, None where a description was given."""
        return None if self.description is not None else Path(text_of(context, self._location))
