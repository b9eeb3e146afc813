"""Gathers what MoveIt is started with from a robot's package, as moveit_configs_utils does."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.errors import one_of
from tracerisk.ros.moveit.parameter_files import (
    PackageFiles,
    ParameterBuilder,
    ParameterBuilderFileNotFoundError,
    load_yaml,
)

if TYPE_CHECKING:
    from typing_extensions import Self

_CONFIG = Path("config")
# moveit/moveit2, moveit_configs_utils/default_configs: the pipelines known without a file.
_PLUGINS = {
    "chomp": "chomp_interface/CHOMPPlanner",
    "ompl": "ompl_interface/OMPLPlanner",
    "pilz_industrial_motion_planner": "pilz_industrial_motion_planner/CommandPlanner",
    "stomp": "stomp_moveit/StompPlanner",
}
# What every robot has, by the methods that load it and the fields that hold it.
_PARTS = (
    "robot_description",
    "robot_description_semantic",
    "robot_description_kinematics",
    "planning_pipelines",
    "trajectory_execution",
    "planning_scene_monitor",
    "sensors_3d",
    "joint_limits",
)
_PILZ = "pilz_industrial_motion_planner"


def get_pattern_matches(folder: Path, pattern: re.Pattern[str]) -> list[Any]:
    """Return the first groups of the names of files that match, or the files themselves."""
    if not folder.exists():
        return []
    matches = [(path, pattern.search(path.name)) for path in sorted(folder.iterdir())]
    return [
        match.groups()[0] if match.groups() else path
        for path, match in matches
        if match is not None and path.is_file()
    ]


@dataclass(slots=True)
class MoveItConfigs:
    """The parameters that MoveIt is started with, by what they are for."""

    package_path: Path | None = None
    """The folder of the robot's MoveIt package; `None` where there is none."""
    robot_description: dict[str, Any] = field(default_factory=dict)
    """The parameter with the URDF."""
    robot_description_semantic: dict[str, Any] = field(default_factory=dict)
    """The parameter with the SRDF."""
    robot_description_kinematics: dict[str, Any] = field(default_factory=dict)
    """The kinematics solvers of the planning groups."""
    planning_pipelines: dict[str, Any] = field(default_factory=dict)
    """The planning pipelines and their settings."""
    trajectory_execution: dict[str, Any] = field(default_factory=dict)
    """The controllers and the rules of execution."""
    planning_scene_monitor: dict[str, Any] = field(default_factory=dict)
    """The topics and rates of the planning scene monitor."""
    sensors_3d: dict[str, Any] = field(default_factory=dict)
    """The sensors that fill the octomap."""
    move_group_capabilities: dict[str, Any] = field(
        default_factory=lambda: {"capabilities": "", "disable_capabilities": ""}
    )
    """The plugins to load into move_group, and those to leave out."""
    joint_limits: dict[str, Any] = field(default_factory=dict)
    """The limits of velocity and acceleration."""
    moveit_cpp: dict[str, Any] = field(default_factory=dict)
    """The parameters of MoveItCpp and moveit_py."""
    pilz_cartesian_limits: dict[str, Any] = field(default_factory=dict)
    """The Cartesian limits of the Pilz planner."""

    def to_dict(self) -> dict[str, Any]:
        """Return all of them as one dictionary of parameters."""
        parameters: dict[str, Any] = {}
        for part in (*_PARTS, "moveit_cpp"):
            parameters.update(getattr(self, part))
        for name, limits in self.pilz_cartesian_limits.items():
            parameters[name] = {**parameters.get(name, {}), **limits}
        return parameters


class ConfigsBuilder(ParameterBuilder):
    """Gathers the parameters of `<robot_name>_moveit_config`, or of the package named.

    Each method takes a file of the package, or an absolute path, in place of the usual file.
    """

    def __init__(
        self,
        files: PackageFiles,
        robot_name: str,
        robot_description: str = "robot_description",
        package_name: str | None = None,
    ) -> None:
        super().__init__(files, package_name or f"{robot_name}_moveit_config")
        self._configs = MoveItConfigs(package_path=self._package_path)
        self._robot_name = robot_name
        self._description = robot_description
        self._urdf_arguments: dict[str, str] | None = None
        self._urdf: Path | None = _CONFIG / f"{robot_name}.urdf"
        self._srdf: Path = _CONFIG / f"{robot_name}.srdf"
        self._ask_setup_assistant()

    def _ask_setup_assistant(self) -> None:
        """Take the places of URDF and SRDF from what MoveIt's setup assistant noted."""
        folder = self._package_path
        if folder is None:
            return
        own = _CONFIG / f"{self._robot_name}.urdf.xacro"
        has_own = (folder / own).exists()
        if has_own:
            self._urdf = own
        noted = folder / ".setup_assistant"
        if not noted.exists():
            return
        config = (
            load_yaml(noted, self._files.text(noted)).get("moveit_setup_assistant_config") or {}
        )
        urdf = config.get("urdf") or config.get("URDF") or {}
        if urdf and not has_own:
            package = self._files.folder(urdf["package"])
            self._urdf = None if package is None else package / urdf["relative_path"]
        if urdf.get("xacro_args"):
            pairs = [pair.partition(":=") for pair in urdf["xacro_args"].split()]
            self._urdf_arguments = {name: value for name, _, value in pairs}
        srdf = config.get("srdf") or config.get("SRDF") or {}
        if srdf:
            self._srdf = Path(srdf["relative_path"])

    def robot_description(
        self, file_path: str | Path | None = None, mappings: Mapping[str, Any] | None = None
    ) -> Self:
        """Load the URDF, expanded where it is a xacro file."""
        path = self._urdf if file_path is None else Path(file_path)
        text = None
        if path is not None:
            try:
                text = self._xacro(path, mappings or self._urdf_arguments)
            except ParameterBuilderFileNotFoundError as error:
                self._files.left_out(str(error))
        self._configs.robot_description = {} if text is None else {self._description: text}
        return self

    def robot_description_semantic(
        self, file_path: str | Path | None = None, mappings: Mapping[str, Any] | None = None
    ) -> Self:
        """Load the SRDF, expanded where it is a xacro file."""
        text = self._xacro(file_path or self._srdf, mappings)
        table = {} if text is None else {f"{self._description}_semantic": text}
        self._configs.robot_description_semantic = table
        return self

    def robot_description_kinematics(self, file_path: str | Path | None = None) -> Self:
        """Load the parameters of inverse kinematics."""
        self._configs.robot_description_kinematics = self._below(
            "_kinematics", file_path or _CONFIG / "kinematics.yaml"
        )
        return self

    def joint_limits(self, file_path: str | Path | None = None) -> Self:
        """Load the joints' limits."""
        self._configs.joint_limits = self._below(
            "_planning", file_path or _CONFIG / "joint_limits.yaml"
        )
        return self

    def moveit_cpp(self, file_path: str | Path | None = None) -> Self:
        """Load the parameters of MoveItPy."""
        self._configs.moveit_cpp = self._yaml(file_path or _CONFIG / "moveit_cpp.yaml")
        return self

    def trajectory_execution(
        self, file_path: str | Path | None = None, moveit_manage_controllers: bool = True
    ) -> Self:
        """Load the controllers' parameters; the file is guessed where there is only one.

        Raises:
            RuntimeError: there are several files, and none has a usual name.
        """
        table: dict[str, Any] = {"moveit_manage_controllers": moveit_manage_controllers}
        path = self._controllers_file() if file_path is None else Path(file_path)
        if path is not None:
            table.update(self._yaml(path))
        self._configs.trajectory_execution = table
        return self

    def planning_scene_monitor(
        self,
        publish_planning_scene: bool = True,
        publish_geometry_updates: bool = True,
        publish_state_updates: bool = True,
        publish_transforms_updates: bool = True,
        publish_robot_description: bool = False,
        publish_robot_description_semantic: bool = False,
    ) -> Self:
        """Set what the monitor of the planning scene publishes."""
        self._configs.planning_scene_monitor = {
            "publish_planning_scene": publish_planning_scene,
            "publish_geometry_updates": publish_geometry_updates,
            "publish_state_updates": publish_state_updates,
            "publish_transforms_updates": publish_transforms_updates,
            "publish_robot_description": publish_robot_description,
            "publish_robot_description_semantic": publish_robot_description_semantic,
        }
        return self

    def sensors_3d(self, file_path: str | Path | None = None) -> Self:
        """Load the parameters of sensors, where there are any."""
        try:
            yaml = self._yaml(file_path or _CONFIG / "sensors_3d.yaml")
        except ParameterBuilderFileNotFoundError:
            return self
        sensors = yaml.get("sensors") or []
        if sensors and sensors[0]:
            self._configs.sensors_3d = yaml
        return self

    def planning_pipelines(
        self,
        default_planning_pipeline: str | None = None,
        pipelines: Sequence[str] | None = None,
        load_all: bool = True,
    ) -> Self:
        """Load the parameters of planning pipelines: those named, those of the package, or all.

        Raises:
            RuntimeError: the default is none of them, or a pipeline has no file.
        """
        folder = None if self._package_path is None else self._package_path / _CONFIG
        if pipelines is None:
            pattern = re.compile("^(.*)_planning.yaml$")
            names = [] if folder is None else get_pattern_matches(folder, pattern)
            pipelines = [*names, *(name for name in _PLUGINS if load_all and name not in names)]
        names = list(pipelines)
        default = default_planning_pipeline or ("ompl" if "ompl" in names else names[0])
        if default not in names:
            raise RuntimeError(
                f"default_planning_pipeline: `{default}` doesn't name any of the input pipelines "
                f"`{','.join(names)}`"
            )
        table: dict[str, Any] = {"planning_pipelines": names, "default_planning_pipeline": default}
        for name in names:
            file = None if folder is None else folder / f"{name}_planning.yaml"
            if file is not None and file.exists():
                table[name] = load_yaml(file, self._files.text(file))
            elif name in _PLUGINS:
                table[name] = {"planning_plugins": [_PLUGINS[name]]}
            else:
                raise RuntimeError(
                    f"planning pipeline '{name}' has no file config/{name}_planning.yaml; "
                    f"known without one: {one_of(_PLUGINS, name)}"
                )
        self._configs.planning_pipelines = table
        return self

    def pilz_cartesian_limits(self, file_path: str | Path | None = None) -> Self:
        """Load the Cartesian limits of the planner of pilz."""
        self._configs.pilz_cartesian_limits = self._below(
            "_planning", file_path or _CONFIG / "pilz_cartesian_limits.yaml"
        )
        return self

    def to_moveit_configs(self) -> MoveItConfigs:
        """Return all parameters, those not loaded yet from their usual files."""
        configs = self._configs
        for part in _PARTS:
            if not getattr(configs, part):
                getattr(self, part)()
        # Known without a file or not, pilz needs its limits only where the package has it.
        limits = None if self._package_path is None else self._package_path / _CONFIG
        has_limits = limits is not None and (limits / "pilz_cartesian_limits.yaml").exists()
        if _PILZ in configs.planning_pipelines and not configs.pilz_cartesian_limits and has_limits:
            self.pilz_cartesian_limits()
        return configs

    def to_dict(self, include_moveit_configs: bool = True) -> dict[str, Any]:
        """Return the parameters added, with MoveIt's unless they are not asked for."""
        if include_moveit_configs:
            self._parameters.update(self.to_moveit_configs().to_dict())
        return self._parameters

    def _below(self, suffix: str, file_path: str | Path) -> dict[str, Any]:
        values = self._yaml(file_path)
        return {f"{self._description}{suffix}": values} if values else {}

    def _controllers_file(self) -> Path | None:
        if self._package_path is None:
            return None
        folder = self._package_path / _CONFIG
        names = get_pattern_matches(folder, re.compile("^(.*)_controllers.yaml$"))
        if not names:
            self._files.left_out(f"a file {folder.name}/*_controllers.yaml")
            return None
        usual = [name for name in ("moveit", "moveit2", self._robot_name) if name in names]
        chosen = names[0] if len(names) == 1 else next(iter(usual), None)
        if chosen is None:
            listed = "\n - ".join(f"{name}_controllers.yaml" for name in names)
            raise RuntimeError(
                "trajectory_execution: Unable to guess which parameter file to load. "
                f"Options:\n - {listed}"
            )
        return folder / f"{chosen}_controllers.yaml"
