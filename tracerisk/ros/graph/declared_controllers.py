"""Controllers that files of the workspace declare, whether or not the robot has their joints."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.parameter_files import flat, read_parameters
from tracerisk.ros.graph.runtime import Runtime

_MOST_FILES = 200  # that may declare a controller
_MOST_BYTES = 200_000
_QUANTITIES = ("position", "velocity", "effort")


@dataclass(frozen=True, slots=True)
class DeclaredController:
    """A controller as a file declares it."""

    joints: tuple[str, ...]
    """The joints that it commands."""
    type: str = ""
    """What it is, `package/Class`; empty where no file says it."""
    interface: str = ""
    """The interface of joints that it forwards commands to: `position`, `velocity`, `effort`."""

    @property
    def quantity(self) -> str:
        """What a topic of numbers commands: `position`, `velocity` or `effort`; empty if unsaid."""
        name = self.type.rpartition("/")[2]
        return next((each for each in _QUANTITIES if each.capitalize() in name), self.interface)


class DeclaredControllers:
    """The controllers that YAML files of the workspace's packages declare, read when asked for."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._folders = tuple(runtime.packages.values())

    @cached_property
    def all(self) -> Mapping[str, DeclaredController]:
        """The controllers by their names; of several files the first counts."""
        found: dict[str, DeclaredController] = {}
        types: dict[str, str] = {}
        interfaces: dict[str, str] = {}
        for name, key, value in declared_settings(self._folders, b"joints"):
            if key == "joints" and isinstance(value, list):
                joints = tuple(str(joint) for joint in value)
                found.setdefault(name, DeclaredController(joints))
            elif key == "type" and isinstance(value, str):
                types.setdefault(name, value)
            elif key == "interface_name" and isinstance(value, str):
                interfaces.setdefault(name, value)
        return {
            name: replace(each, type=types.get(name, ""), interface=interfaces.get(name, ""))
            for name, each in found.items()
        }

    def of_robot(self, joints: Iterable[str]) -> Mapping[str, DeclaredController]:
        """Return those of which a robot with these joints has every joint."""
        known = {*joints}
        return {name: each for name, each in self.all.items() if known.issuperset(each.joints)}

    def of_topic(self, topic: str) -> DeclaredController | None:
        """Return the controller that takes a topic's commands, if a file declares it."""
        namespaces = [part for part in topic.split("/")[:-1] if part in self.all]
        return self.all[namespaces[-1]] if namespaces else None


def declared_settings(
    folders: Iterable[Path], word: bytes, *, first: bool = False
) -> Iterator[tuple[str, str, Any]]:
    """Yield each setting of the YAML files below folders that hold a word.

    It is in whose namespace it stands, its own name, and its value. With `first` only those of
    the first such file come.
    """
    for path in islice(_files(folders, word), _MOST_FILES):
        try:
            parameters = read_parameters(path)
        except ScenarioError:
            continue
        for each in parameters:
            for name, value in flat(f"{each.node or ''}/{each.name}", each.value):
                *_, above, last = name.replace(".", "/").split("/")
                yield above, last, value
        if first and parameters:
            return


def _files(folders: Iterable[Path], word: bytes) -> Iterator[Path]:
    for top in folders:
        for folder, inner, files in os.walk(top):
            inner[:] = sorted(each for each in inner if not each.startswith("."))
            for file in sorted(files):
                path = Path(folder, file)
                if not file.endswith((".yaml", ".yml")) or path.stat().st_size > _MOST_BYTES:
                    continue
                if word in path.read_bytes():
                    yield path
