"""MoveItConfigsBuilder: gathers what MoveIt is started with from a package of the workspace."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tracerisk.errors import RobotError
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.configs import ConfigsBuilder, MoveItConfigs, get_pattern_matches
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.parameter_files import ParameterBuilderFileNotFoundError
from tracerisk.twin.urdf.xacro_files import expand_xacro

__all__ = [
    "MoveItConfigs",
    "MoveItConfigsBuilder",
    "ParameterBuilderFileNotFoundError",
    "get_pattern_matches",
]


class _WorkspaceFiles:
    """The packages of the run's workspace; what is left out is a finding, reported once."""

    def folder(self, package: str) -> Path | None:
        packages = current().findable
        if package in packages:
            return packages[package]
        self._report(
            f"package '{package}' is not in {current().searched}; its parameters are left out"
        )
        return None

    def text(self, path: Path) -> str:
        return path.read_text(encoding="utf-8")

    def expanded(self, path: Path, arguments: Mapping[str, Any]) -> str | None:
        given = {name: str(value) for name, value in arguments.items()}
        try:
            return expand_xacro(path, current().findable, arguments=given).decode()
        except RobotError as error:
            self._report(f"{path.name} cannot be expanded, and is left out: {error.message}")
            return None

    def left_out(self, what: str) -> dict[str, Any]:
        if not what.startswith("package "):
            self._report(f"{what} is not there; its parameters are left out")
        return {}

    def _report(self, message: str) -> None:
        current().client(MoveGroupServer).execution.report("configuration", message)


class MoveItConfigsBuilder(ConfigsBuilder):
    """Gathers the parameters of `<robot_name>_moveit_config`, or of the package named.

    A package that the workspace lacks is a finding of the run, which goes on without what it
    would give.
    """

    def __init__(
        self,
        robot_name: str,
        robot_description: str = "robot_description",
        package_name: str | None = None,
    ) -> None:
        super().__init__(_WorkspaceFiles(), robot_name, robot_description, package_name)
