"""Parameters gathered from the files of a package, as launch_param_builder does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from tracerisk.ros.graph import yaml_text

if TYPE_CHECKING:
    from typing_extensions import Self


class PackageFiles(Protocol):
    """Where packages are, and what is done about what is not there."""

    def folder(self, package: str) -> Path | None:
        """Return the folder of a package; None where it is not there."""

    def text(self, path: Path) -> str:
        """Return the text of a file."""

    def expanded(self, path: Path, arguments: Mapping[str, Any]) -> Any:
        """Return what a xacro file expands to; None where it cannot be expanded."""

    def left_out(self, what: str) -> dict[str, Any]:
        """Note what is left out, and return what stands for its parameters: `*`, or nothing."""


class ParameterBuilderFileNotFoundError(FileNotFoundError):
    """A file of parameters is not there."""


class ParameterBuilder:
    """Gathers parameters from a package.

    What the files of a package that is not there would give is left out: the robot is that of
    the run in any case.
    """

    def __init__(self, files: PackageFiles, package_name: str) -> None:
        self._files = files
        self._package_name = package_name
        self._parameters: dict[str, Any] = {}
        self._package_path = files.folder(package_name)

    def yaml(self, file_path: str | Path, parameter_namespace: str | None = None) -> Self:
        """Add the parameters of a YAML file, below a namespace if one is given."""
        return self._add(parameter_namespace, self._yaml(file_path))

    def file_parameter(self, parameter_name: str, file_path: str | Path) -> Self:
        """Add the text of a file as a parameter."""
        path = self._path(file_path)
        return self if path is None else self.parameter(parameter_name, self._files.text(path))

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
        below = self._parameters.setdefault(namespace, {}) if namespace else self._parameters
        below.update(values)
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

    def _missing(self, file_path: str | Path) -> str:  # noqa: ARG002 - others go by the file
        """Return what is not there where a file has no path."""
        return f"package '{self._package_name}'"

    def _yaml(self, file_path: str | Path) -> dict[str, Any]:
        path = self._path(file_path)
        if path is None:
            return self._files.left_out(self._missing(file_path))
        return load_yaml(path, self._files.text(path))

    def _xacro(self, file_path: str | Path, mappings: Mapping[str, Any] | None) -> Any:
        """Return what a file expands to; None where it is not there or cannot be expanded."""
        path = self._path(file_path)
        if path is None:
            return self._files.left_out(self._missing(file_path)).get("*")
        if path.suffix != ".xacro":
            return self._files.text(path)
        return self._files.expanded(
            path, {str(name): value for name, value in (mappings or {}).items()}
        )


def load_yaml(path: Path, text: str) -> dict[str, Any]:
    """Return what the text of a YAML file holds.

    Raises:
        RuntimeError: it is not YAML, or holds no mapping.
    """
    from ruamel.yaml.error import YAMLError

    try:
        content = yaml_text.load_yaml(text)
    except YAMLError as error:
        raise RuntimeError(f"{path} is not YAML: {error}") from error
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise RuntimeError(f"{path} holds no mapping; give parameters as 'name: value'")
    return dict(content)
