"""ParameterBuilder and its readers of files, over the packages of the run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tracerisk.errors import RobotError
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit import parameter_files
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.twin.urdf.xacro_files import expand_xacro

ParameterBuilderFileNotFoundError = parameter_files.ParameterBuilderFileNotFoundError


class WorkspaceFiles:
    """The packages of the run's workspace; what is left out is a finding, reported once."""

    def folder(self, package: str) -> Path | None:
        """Return the folder of a package; None, and a finding, where it is not there."""
        packages = current().findable
        if package in packages:
            return packages[package]
        self._report(
            f"package '{package}' is not in {current().searched}; its parameters are left out"
        )
        return None

    def text(self, path: Path) -> str:
        """Return the text of a file."""
        return path.read_text(encoding="utf-8")

    def expanded(self, path: Path, arguments: Mapping[str, Any]) -> str | None:
        """Return what a xacro file expands to; None, and a finding, where it cannot be expanded."""
        given = {name: str(value) for name, value in arguments.items()}
        try:
            return expand_xacro(path, current().findable, arguments=given).decode()
        except RobotError as error:
            self._report(f"{path.name} cannot be expanded, and is left out: {error.message}")
            return None

    def left_out(self, what: str) -> dict[str, Any]:
        """Report what is left out, unless its package is; return no parameters."""
        if not what.startswith("package "):
            self._report(f"{what} is not there; its parameters are left out")
        return {}

    def _report(self, message: str) -> None:
        current().client(MoveGroupServer).execution.report("configuration", message)


class ParameterBuilder(parameter_files.ParameterBuilder):
    """Gathers parameters from the files of a package.

    A package that the workspace lacks is a finding of the run, which goes on without what it
    would give.
    """

    def __init__(self, package_name: str) -> None:
        super().__init__(WorkspaceFiles(), package_name)


def raise_if_file_not_found(file_path: str | Path) -> None:
    """Raise an error if a file is not there.

    Raises:
        ParameterBuilderFileNotFoundError: it is not.
    """
    if not Path(file_path).exists():
        raise ParameterBuilderFileNotFoundError(f"File {file_path} doesn't exist")


def load_file(file_path: str | Path) -> str:
    """Return the text of a file."""
    raise_if_file_not_found(file_path)
    return WorkspaceFiles().text(Path(file_path))


def load_yaml(file_path: str | Path) -> dict[str, Any]:
    """Return the parameters of a YAML file."""
    return parameter_files.load_yaml(Path(file_path), load_file(file_path))


def load_xacro(file_path: str | Path, mappings: Mapping[str, str] | None = None) -> str | None:
    """Return what a xacro file expands to; None, and a finding, where it cannot be expanded."""
    raise_if_file_not_found(file_path)
    return WorkspaceFiles().expanded(Path(file_path), mappings or {})
