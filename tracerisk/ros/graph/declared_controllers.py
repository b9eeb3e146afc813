"""Controllers that files of the workspace declare, whether or not the robot has their joints."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.parameter_files import read_parameters

_MOST_FILES = 200  # that may declare a controller
_MOST_BYTES = 200_000


def declared_joints(folders: Iterable[Path], topic: str) -> tuple[str, ...]:
    """Return the joints of the controller whose commands a topic takes; () where none is declared.

    It is looked for in the YAML files below `folders`, those of the workspace's packages.
    """
    controllers = {part for part in topic.split("/")[:-1] if part}
    for path in islice(_files(folders, controllers), _MOST_FILES):
        try:
            parameters = read_parameters(path)
        except ScenarioError:
            continue
        for each in parameters:
            for name, value in _leaves(f"{each.node or ''}/{each.name}", each.value):
                controller, _, last = name.rpartition("/")
                is_meant = last == "joints" and controller.rpartition("/")[2] in controllers
                if is_meant and isinstance(value, list):
                    return tuple(str(joint) for joint in value)
    return ()


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(value, dict):
        yield name, value
        return
    for key, inner in value.items():
        yield from _leaves(f"{name}/{key}", inner)


def _files(folders: Iterable[Path], names: Iterable[str]) -> Iterator[Path]:
    wanted = [name.encode() for name in names]
    for top in folders:
        for folder, inner, files in os.walk(top):
            inner[:] = sorted(each for each in inner if not each.startswith("."))
            for file in sorted(files):
                path = Path(folder, file)
                if not file.endswith((".yaml", ".yml")) or path.stat().st_size > _MOST_BYTES:
                    continue
                text = path.read_bytes()
                if any(name in text for name in wanted):
                    yield path
