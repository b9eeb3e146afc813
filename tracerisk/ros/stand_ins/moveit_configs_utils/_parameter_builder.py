"""Parameters gathered from the files of a package; the base that launch_param_builder gives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from tracerisk.errors import RobotError
from tracerisk.ros.move_group import MoveGroupServer
from tracerisk.ros.runtime import current
from tracerisk.twin.xacro_files import expand_xacro


class ParameterBuilderFileNotFoundError(FileNotFoundError):
    """A file of parameters is not there."""


class ParameterBuilder:
    """Gathers parameters from a package of the workspace.

    A package that the workspace lacks is a finding of the run, and what its files would give is
    left out: the robot is that of the run in any case.
    """

    def __init__(self, package_name: str) -> None:
        self._parameters: dict[str, Any] = {}
        self._package_path: Path | None = None
        try:
            self._package_path = Path(get_package_share_directory(package_name))
        except PackageNotFoundError as error:
            tell(f"{error.args[0]}; its parameters are left out")

    def yaml(self, file_path: str | Path, parameter_namespace: str | None = None) -> Self:
        """Add the parameters of a YAML file, below a namespace if one is given."""
        return self._add(parameter_namespace, self._yaml(file_path))

    def file_parameter(self, parameter_name: str, file_path: str | Path) -> Self:
        """Add the text of a file as a parameter."""
        path = self._path(file_path)
        return self if path is None else self.parameter(parameter_name, read_text(path))

    def xacro_parameter(
        self, parameter_name: str, file_path: str | Path, mappings: Mapping[str, str] | None = None
    ) -> Self:
        """Add what a xacro file expands to as a parameter."""
        text = self._xacro(file_path, mappings)
        return self if text is None else self.parameter(parameter_name, text)

    def parameter(self, parameter_name: str, parameter_value: Any) -> Self:
        """Add a parameter."""
        self._parameters[parameter_name] = parameter_value
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return the parameters."""
        return self._parameters

    def _add(self, namespace: str | None, values: Mapping[str, Any]) -> Self:
        self._parameters.update({namespace: values} if namespace else values)
        return self

    def _path(self, file_path: str | Path) -> Path | None:
        """Return where a file is; None where it is in a package that is not there.

        Raises:
            ParameterBuilderFileNotFoundError: the package lacks the file.
        """
        path = Path(file_path)
        if not path.is_absolute():
            if self._package_path is None:
                return None
            path = self._package_path / path
        if not path.exists():
            raise ParameterBuilderFileNotFoundError(f"File {path} doesn't exist")
        return path

    def _yaml(self, file_path: str | Path) -> dict[str, Any]:
        path = self._path(file_path)
        return {} if path is None else load_yaml(path)

    def _xacro(self, file_path: str | Path, mappings: Mapping[str, Any] | None) -> str | None:
        """Return what a file expands to; None, with a finding, where it cannot be expanded."""
        path = self._path(file_path)
        if path is None:
            return None
        if path.suffix != ".xacro":
            return read_text(path)
        arguments = {str(name): str(value) for name, value in (mappings or {}).items()}
        try:
            return expand_xacro(path, current().packages, arguments=arguments).decode()
        except RobotError as error:
            tell(f"{path.name} cannot be expanded, and is left out: {error.message}")
            return None


def load_yaml(path: Path) -> dict[str, Any]:
    """Return what a YAML file holds.

    Raises:
        RuntimeError: it is no YAML, or holds no mapping.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    yaml = YAML(typ="safe", pure=True)
    yaml.version = (1, 1)
    try:
        content = yaml.load(read_text(path))
    except YAMLError as error:
        raise RuntimeError(f"{path} is no YAML: {error}") from error
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise RuntimeError(f"{path} holds no mapping; give parameters as 'name: value'")
    return dict(content)


def read_text(path: Path) -> str:
    """Return the text of a file."""
    return path.read_text(encoding="utf-8")


def tell(message: str) -> None:
    """Record a finding of the run where the controller stands."""
    current().client(MoveGroupServer).execution.tell("configuration", message)
