"""`launch.launch_description_sources`: all are told apart by the names of their files."""

from __future__ import annotations

from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description_source import (
    LaunchDescriptionSource,
)


class InvalidLaunchFileError(Exception):
    """A launch file cannot be read."""


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
