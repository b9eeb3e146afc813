"""`launch_ros.substitutions`."""

from __future__ import annotations

import importlib
from typing import Any

from tracerisk.pipeline.launch_files.placeholders import AbsentError
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.pipeline.launch_files.stand_ins.launch.substitutions import (
    PathSubstitution,
    SubstitutionFailure,
)
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of


class FindPackage(PathSubstitution):
    """The folder of a package of the workspace: its source, for nothing is installed."""

    def __init__(self, package: Any) -> None:
        super().__init__("")
        self.package = package
        self._parts = [_Folder(package)]

    def find(self, package_name: str) -> str:
        """Return the folder of a package, where no context is at hand."""
        index = importlib.import_module("ament_index_python.packages")
        return str(index.get_package_share_directory(package_name))

    def perform(self, context: Any) -> str:
        """Return the folder; raise AbsentError where the workspace has no such package."""
        return text_of(context, self._parts[0])


class _Folder(Substitution):
    def __init__(self, package: Any) -> None:
        self._package = package

    def perform(self, context: Any) -> str:
        name = text_of(context, self._package)
        if name not in context.packages:
            raise AbsentError(f"package '{name}' is not here")
        return str(context.packages[name])


class FindPackageShare(FindPackage):
    """The folder of a package's files."""


class FindPackagePrefix(FindPackage):
    """The folder of a package."""


class ExecutableInPackage(Substitution):
    """A program of a package: known by its name alone, for none is started."""

    def __init__(self, executable: Any, package: Any) -> None:
        self.executable, self.package = executable, package

    def perform(self, context: Any) -> str:
        """Return the program's name."""
        return text_of(context, self.executable)


class Parameter(Substitution):
    """A parameter that `SetParameter` has set for all nodes."""

    def __init__(self, name: Any, *, default: Any = None) -> None:
        self.name, self.default = name, default

    def perform(self, context: Any) -> str:
        """Return its value as text."""
        name = text_of(context, self.name)
        for item in reversed(context.launch_configurations.get("global_params", [])):
            if item.name == name:
                return str(item.value)
        if self.default is None:
            raise SubstitutionFailure(f"parameter '{name}' is not set")
        return text_of(context, self.default)
