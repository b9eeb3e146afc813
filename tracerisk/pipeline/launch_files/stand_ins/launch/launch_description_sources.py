"""`launch.launch_description_sources`: all are distinguished by the names of their files."""

from __future__ import annotations

from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_source import (
    LaunchDescriptionSource,
)


class InvalidLaunchFileError(Exception):
    """A launch file cannot be read: why, in the errors of those who tried."""

    def __init__(self, extension: str = "", *, likely_errors: Any = None) -> None:
        lines = [
            f"{type(likely_error).__name__}: {likely_error}" for likely_error in likely_errors or ()
        ]
        kind = f"Caught errors when trying to load a launch file of the kind [{extension}]"
        super().__init__(f"{kind}: {'; '.join(lines)}" if lines else extension)
        self.extension, self.likely_errors = extension, likely_errors


InvalidPythonLaunchFileError = InvalidLaunchFileError


class AnyLaunchDescriptionSource(LaunchDescriptionSource):
    """A launch file of any kind."""

    def __init__(self, launch_file_path: Any) -> None:
        super().__init__(location=launch_file_path)


class PythonLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in Python."""


class FrontendLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in XML or YAML."""


class XMLLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in XML."""


class YAMLLaunchDescriptionSource(AnyLaunchDescriptionSource):
    """A launch file in YAML."""
