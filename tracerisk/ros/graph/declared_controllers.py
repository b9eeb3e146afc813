"""Controllers that files of the workspace declare, whether or not the robot has their joints."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

from tracerisk.common.hardware.source_files import describes_hardware
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import ScenarioError
from tracerisk.ros.graph.parameter_files import Parameter, flat, read_parameters

_MOST_FILES = 200  # that may declare a controller
_MOST_BYTES = 200_000
_MOVEIT = "moveit_simple_controller_manager"
_VARIABLE = re.compile(r"^\$\((?:var|arg) \w+\)")
_QUANTITIES = ("position", "velocity", "effort")
_OF_ONE_JOINT = re.compile(r"/Joint(?:Position|Velocity|Effort)Controller$|ripper")
"""The types whose parameter `joint` is what they command: `joint` is said of much else, too."""


@dataclass(frozen=True, slots=True)
class DeclaredController:
    """A controller as a file declares it."""

    joints: tuple[str, ...]
    """The joints that it commands."""
    type: str = ""
    """What it is, `package/Class`; empty where no file says it."""
    interface: str = ""
    """The interface of joints that it forwards commands to: `position`, `velocity`, `effort`."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """All its parameters by their dotted names; of several files the first that gives one counts.
    Empty where only MoveIt's files name it: they say nothing of what it does."""
    others: tuple[tuple[str, ...], ...] = ()
    """The joints that other files give a controller of this name: those of a workspace's other
    robots and bring-ups."""
    is_default: bool = False
    """Whether a file of MoveIt's says that it takes the goals for its joints by default."""

    def of_joints(self, fits: Callable[[frozenset[str]], bool]) -> DeclaredController | None:
        """Return it with the first of its lists of joints that fits, `None` where none does."""
        lists = (self.joints, *self.others)
        joints = next((names for names in lists if fits(frozenset(names))), None)
        return None if joints is None else replace(self, joints=joints)

    @property
    def quantity(self) -> str:
        """What a topic of numbers commands: `position`, `velocity` or `effort`; empty if unsaid."""
        name = self.type.rpartition("/")[2]
        return next((text for text in _QUANTITIES if text.capitalize() in name), self.interface)


class _WithPackages(Protocol):
    @property
    def packages(self) -> Mapping[str, Path]:
        """The folders of packages, by name."""


class DeclaredControllers:
    """The controllers that YAML files of the workspace's packages declare, read when asked for."""

    is_of_world = True

    def __init__(self, runtime: _WithPackages) -> None:
        self._folders = tuple(runtime.packages.values())

    @cached_property
    def all(self) -> Mapping[str, DeclaredController]:
        """The controllers by their names; of several files the first counts."""
        return {
            name: controller for name, controller in self._declared.items() if controller.joints
        }

    @cached_property
    def without_joints(self) -> Mapping[str, DeclaredController]:
        """Those of which files give the type alone: broadcasters, and modes of a driver."""
        return {
            name: controller for name, controller in self._declared.items() if not controller.joints
        }

    @cached_property
    def _declared(self) -> Mapping[str, DeclaredController]:
        joints: dict[str, list[tuple[str, ...]]] = {}
        types: dict[str, str] = {}
        of_one: set[str] = set()
        defaults: set[str] = set()
        settings: dict[str, dict[str, Any]] = {}
        for values in _settings(self._folders, b"joint"):
            for place, value in values.items():
                above, last = place[:-1], place[-1]
                name = above[-1] if above else ""
                if last == "type" and isinstance(value, str):
                    # MoveIt's files call it by its action alone.
                    if "/" in value or name not in types:
                        types[name] = value
                elif last == "default" and value is True and _MOVEIT in above:
                    defaults.add(name)
                elif moved := _moved_joints(last, value):
                    joints.setdefault(name, []).append(moved)
                    of_one |= {name} if last == "joint" else set()
                    if _MOVEIT not in above:
                        own = settings.setdefault(name, {})
                        for key, item in _below(values, above):
                            own.setdefault(key, item)
        with_joints = {
            name: DeclaredController(
                moved,
                types.get(name, ""),
                str(settings.get(name, {}).get("interface_name", "")),
                settings.get(name, {}),
                tuple(others),
                name in defaults,
            )
            for name, (moved, *others) in joints.items()
            if len(moved) != 1 or name not in of_one or _OF_ONE_JOINT.search(types.get(name, ""))
        }
        alone = {
            name: DeclaredController((), kind)
            for name, kind in types.items()
            if name not in with_joints
            and "/" in kind
            and kind.endswith(("Controller", "Broadcaster"))
        }
        return with_joints | alone

    def of_robot(self, joints: Iterable[str]) -> Mapping[str, DeclaredController]:
        """Return those of which a robot with these joints has every joint."""
        known = {*joints}
        table = {
            name: controller.of_joints(known.issuperset) for name, controller in self.all.items()
        }
        return {name: controller for name, controller in table.items() if controller is not None}

    def of_topic(self, topic: str) -> DeclaredController | None:
        """Return the controller that takes a topic's commands, if a file declares it."""
        namespaces = [part for part in topic.split("/")[:-1] if part in self.all]
        return self.all[namespaces[-1]] if namespaces else None


def _by_path(parameters: Iterable[Parameter]) -> dict[tuple[str, ...], Any]:
    """Return the parameters of a file by the names on the way to each."""
    return {
        tuple(name.replace(".", "/").strip("/").split("/")): value
        for parameter in parameters
        for name, value in flat(f"{parameter.node or ''}/{parameter.name}", parameter.value)
    }


def _moved_joints(key: str, value: Any) -> tuple[str, ...]:
    """Return the joints that a parameter names: `joints`, or `joint` of one of a single joint.

    A variable of a launch file before a name is a prefix, by default an empty one.
    """
    if key == "joints" and isinstance(value, list):
        return tuple(_VARIABLE.sub("", str(joint)) for joint in value)
    is_one = key == "joint" and isinstance(value, str)
    return (_VARIABLE.sub("", value),) if is_one else ()


def _below(
    values: Mapping[tuple[str, ...], Any], above: tuple[str, ...]
) -> Iterator[tuple[str, Any]]:
    for place, value in values.items():
        if place[: len(above)] == above and len(place) > len(above):
            yield ".".join(place[len(above) :]), value


def declared_settings(
    folders: Iterable[Path], word: bytes, *, first: bool = False
) -> Iterator[tuple[str, str, Any]]:
    """Yield each setting of the YAML files below folders that hold a word.

    It is in whose namespace it stands, its own name, and its value. With `first` only those of
    the first such file come.
    """
    for values in _settings(folders, word):
        for place, value in values.items():
            yield place[-2] if len(place) > 1 else "", place[-1], value
        if first and values:
            return


def _settings(folders: Iterable[Path], word: bytes) -> Iterator[dict[tuple[str, ...], Any]]:
    """Yield what each YAML file below folders that holds a word sets, by the names on the way."""
    for path in islice(_files(folders, word), _MOST_FILES):
        with contextlib.suppress(ScenarioError):
            yield _by_path(read_parameters(path))


def _files(folders: Iterable[Path], word: bytes) -> Iterator[Path]:
    for top in folders:
        for folder, inner, files in os.walk(top):
            inner[:] = sorted(name for name in inner if not name.startswith("."))
            for file in sorted(files):
                path = Path(folder, file)
                if file.startswith(".") or not file.endswith((".yaml", ".yml")):
                    continue
                # What cannot be read, or only outside the sandbox, declares nothing.
                with contextlib.suppress(OSError):
                    data = file_bytes(path) if path.stat().st_size <= _MOST_BYTES else b""
                    if word in data and not describes_hardware(data):
                        yield path
