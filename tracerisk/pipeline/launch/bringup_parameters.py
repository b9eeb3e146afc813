"""Parameters that the launch files and YAML files of a ROS 1 workspace set for other nodes.

A controller that is run alone asks for what the bringup of its robot would have set: the joints of
`/arm_controller`, the limits of a gripper.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.launch.find import is_test, launch_texts
from tracerisk.pipeline.launch.parameter_files import parameter_files
from tracerisk.pipeline.launch_files.parameter_text import (
    ParameterTextError,
    read_text,
    with_angles,
    yaml_value,
)
from tracerisk.pipeline.launch_files.roslaunch_xml import read_roslaunch
from tracerisk.pipeline.workspace.package_folders import declared_needs
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.ros.graph.parameters import ParameterTree
from tracerisk.twin.workspace.description_files import distance

_MOST_READ = 100

OnGiven = Callable[[str, tuple[Path, ...]], None]
"""Called with the name of a parameter that was given, and the files that it is from."""


class ParametersAround:
    """Answers what a parameter is by the files of the workspace, the nearest to a script first.

    Launch files go before YAML files that none of them loads for a name, and those of tests come
    last. Behind them are YAML files of the installed packages that its manifest names. Files are
    read when the first parameter is asked for.
    """

    def __init__(self, script: Path, root: Path, workspace: Workspace, on_given: OnGiven) -> None:
        self._script = script.resolve()
        self._root = root.resolve()
        self._workspace = workspace
        self._on_given = on_given
        self._trees: list[tuple[ParameterTree, tuple[Path, ...]]] | None = None

    def __call__(self, name: str) -> Any:
        """Return the value of a global name, or the dictionary of a namespace; `None` for none."""
        if self._trees is None:
            own = {
                self._root,
                *(package.resolve() for package in self._workspace.packages.values()),
            }
            installed = self._workspace.installed
            needs = (installed[name] for name in declared_needs(self._root) if name in installed)
            self._trees = [
                *self._launched(),
                *_loaded(own, self._rank),
                *_loaded(needs, self._rank),
            ]
        for tree, files in self._trees:
            if tree.has(name):
                self._on_given(name, files)
                return tree.get(name)
        return None

    def _launched(self) -> Iterator[tuple[ParameterTree, tuple[Path, ...]]]:
        texts = launch_texts(self._root, self._workspace, 1)
        nearest = sorted(texts, key=lambda path: (is_test(path, self._root), *self._rank(path)))
        packages = self._workspace.findable
        for path in nearest[:_MOST_READ]:
            reading = read_roslaunch(path, packages)
            given = {parameter.name: parameter.value for parameter in reading.parameters}
            if given:
                yield _tree(given), tuple(dict.fromkeys((path, *reading.sources)))

    def _rank(self, path: Path) -> tuple[int, Path]:
        return distance(self._script, path), path


def _loaded(
    folders: Iterable[Path], rank: Callable[[Path], tuple[int, Path]]
) -> Iterator[tuple[ParameterTree, tuple[Path, ...]]]:
    files = {path.resolve() for folder in folders for path in parameter_files(folder)}
    for path in sorted(files, key=rank)[:_MOST_READ]:
        try:
            value = with_angles(yaml_value(read_text(path)))
        except (OSError, ParameterTextError, TraceRiskError):
            # It may be of anything: what is not a file of parameters gives none.
            continue
        if isinstance(value, dict) and "ros__parameters" not in str(value):
            yield _tree({f"/{key}": item for key, item in value.items()}), (path,)


def _tree(given: Mapping[str, Any]) -> ParameterTree:
    tree = ParameterTree()
    for name, value in given.items():
        try:
            tree.set(name, value)
        except (TypeError, OverflowError):
            # The server would not take it either.
            continue
    return tree
