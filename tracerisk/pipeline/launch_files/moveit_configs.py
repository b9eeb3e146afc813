"""`moveit_configs_utils` and `launch_param_builder` for launch files: parameters of packages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from tracerisk.common.text.bounded import file_text
from tracerisk.pipeline.launch_files.placeholders import ABSENT_FOLDER, Absent, AbsentModule
from tracerisk.pipeline.launch_files.robot_sources import is_robot_file
from tracerisk.ros.moveit import parameter_files
from tracerisk.ros.moveit.configs import ConfigsBuilder, MoveItConfigs


def moveit_configs_modules(
    packages: Mapping[str, Path],
    on_read: Callable[[Path], None],
    on_robot: Callable[[tuple[str, Mapping[str, Any]]], None],
) -> dict[str, ModuleType]:
    """Return the modules by their names.

    `on_read` is called with each file that is read, `on_robot` with each that describes a robot.
    """
    files = _Files(packages, on_read, on_robot)

    class MoveItConfigsBuilder(_LaunchBuilder):
        def __init__(
            self,
            robot_name: str,
            robot_description: str = "robot_description",
            package_name: str | None = None,
        ) -> None:
            super().__init__(files, robot_name, robot_description, package_name)

    class ParameterBuilder(_LaunchPaths, parameter_files.ParameterBuilder):
        def __init__(self, package_name: str) -> None:
            super().__init__(files, package_name)

    builders: dict[str, dict[str, Any]] = {
        "launch_param_builder": {"ParameterBuilder": ParameterBuilder},
        "moveit_configs_utils": {
            "MoveItConfigs": MoveItConfigs,
            "MoveItConfigsBuilder": MoveItConfigsBuilder,
        },
    }
    builders["moveit_configs_utils.moveit_configs_builder"] = builders["moveit_configs_utils"]
    modules: dict[str, ModuleType] = {}
    for name, provided in builders.items():
        # The launch descriptions that the real package makes start no controller.
        module = modules[name] = AbsentModule(name)
        module.__path__ = []
        vars(module).update(provided)
    return modules


@dataclass(frozen=True, slots=True)
class _Files:
    """The packages of the workspace; what is not there is an absent value."""

    packages: Mapping[str, Path]
    """The folders of the workspace's packages, by package name."""
    on_read: Callable[[Path], None]
    """Called with each file that is read."""
    on_robot: Callable[[tuple[str, Mapping[str, Any]]], None]
    """Called with the path and xacro arguments of each robot description."""

    def folder(self, package: str) -> Path | None:
        return self.packages.get(package)

    def text(self, path: Path) -> str:
        self.on_read(path)
        if is_robot_file(path):
            self.on_robot((str(path), {}))
        return file_text(path)

    def expanded(self, path: Path, arguments: Mapping[str, Any]) -> Absent:
        # A controller needs no URDF: the robot is that of the run.
        self.on_robot((str(path), arguments))
        return Absent("the output of xacro")

    def left_out(self, what: str) -> dict[str, Any]:
        return {"*": Absent(what)}


class _LaunchPaths(parameter_files.ParameterBuilder):
    """A builder whose paths may lead to what is not here."""

    def _path(self, file_path: Any) -> Path | None:
        if isinstance(file_path, Absent) or Path(file_path).is_relative_to(ABSENT_FOLDER):
            return None
        return super()._path(file_path)

    def _missing(self, file_path: Any) -> str:
        if isinstance(file_path, Absent):
            return file_path.words
        path = Path(file_path)
        if path.is_relative_to(ABSENT_FOLDER) and path != ABSENT_FOLDER:
            return f"package '{path.relative_to(ABSENT_FOLDER).parts[0]}'"
        return super()._missing(path)


class _LaunchBuilder(_LaunchPaths, ConfigsBuilder):
    """A builder of MoveIt's parameters, whose package may be absent."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        if self._configs.package_path is None:
            self._configs.package_path = ABSENT_FOLDER / self._package_name
