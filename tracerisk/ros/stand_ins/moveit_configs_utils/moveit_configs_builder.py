"""MoveItConfigsBuilder: gathers what MoveIt is started with from a package of the workspace."""

from __future__ import annotations

from launch_param_builder.parameter_builder import WorkspaceFiles

from tracerisk.ros.moveit.configs import ConfigsBuilder, MoveItConfigs, get_pattern_matches
from tracerisk.ros.moveit.parameter_files import ParameterBuilderFileNotFoundError

__all__ = [
    "MoveItConfigs",
    "MoveItConfigsBuilder",
    "ParameterBuilderFileNotFoundError",
    "get_pattern_matches",
]


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
        super().__init__(WorkspaceFiles(), robot_name, robot_description, package_name)
