"""`launch_ros.descriptions`."""

from __future__ import annotations

from typing import Any

from tracerisk.pipeline.launch_files.stand_ins.launch_ros.parameter_descriptions import (
    Parameter,
    ParameterFile,
    ParameterValue,
)

__all__ = ["ComposableNode", "Parameter", "ParameterFile", "ParameterValue"]


class ComposableNode:
    """A node written in C++, as a plugin: no controller in Python is one."""

    def __init__(self, *, package: Any, plugin: Any, **rest: Any) -> None:
        self.package, self.plugin, self.rest = package, plugin, rest
