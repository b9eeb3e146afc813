"""Read ROS 1 launch files: nodes, parameters and remappings by the defaults of the arguments."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tracerisk.errors import RobotError
from tracerisk.pipeline.launch_files.parameter_text import (
    ParameterTextError,
    read_text,
    with_angles,
    yaml_value,
)
from tracerisk.pipeline.launch_files.records import LaunchParameter, LaunchReading, StartedNode
from tracerisk.pipeline.launch_files.robot_sources import (
    RobotSource,
    is_robot_file,
    robots_read,
    source_of_command,
    source_of_file,
    source_of_problem,
)
from tracerisk.pipeline.launch_files.roslaunch_texts import RoslaunchError, Texts, typed
from tracerisk.ros.graph import graph_names
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

_DEEPEST = 30
_MOST_ELEMENTS = 20_000
_MOST_FILES = 500
_WIRE_LIMIT = 2**31


@dataclass(frozen=True, slots=True)
class _Scope:
    """What holds at a place of a file."""

    texts: Texts
    """The substitutions of the file."""
    namespace: str = "/"
    """The namespace at the place, absolute."""
    owner: str | None = None
    """The full name of the enclosing node, whose `~` names are its; `None` outside a node."""
    remaps: list[tuple[str, str]] = field(default_factory=list)
    """The old and new name of each remap that holds."""
    environment: dict[str, str] = field(default_factory=dict)
    """The environment variables that are set, by name."""
    given: Mapping[str, str] = field(default_factory=dict)
    """The arguments that the including file or the command line gives."""
    depth: int = 0
    """The number of including files."""

    def within(self, namespace: str) -> _Scope:
        """Return a scope of its own within a namespace."""
        space = graph_names.join(self.namespace, namespace) if namespace else self.namespace
        return replace(
            self, namespace=space, remaps=list(self.remaps), environment=dict(self.environment)
        )


def read_roslaunch(
    path: Path, packages: Mapping[str, Path], arguments: Sequence[tuple[str, str]] = ()
) -> LaunchReading:
    """Return what a ROS 1 launch file starts; what cannot be read is among its problems.

    `arguments` are those that its command line gives it; the others have their defaults.
    """
    reader = _Reader(packages)
    scope = _Scope(Texts(packages, path.parent), given=dict(arguments))
    try:
        reader.file(path, scope)
    except (RobotError, ParameterTextError, RoslaunchError) as error:
        reader.problems.append(f"{path.name}: {error}")
    return LaunchReading(
        tuple(reader.nodes),
        tuple(LaunchParameter(None, name, value) for name, value in reader.parameters.items()),
        tuple(reader.left_out.items()),
        tuple(reader.sources),
        tuple(reader.problems),
        robots_read(reader.robots),
        tuple(reader.missing),
    )


class _Reader:
    def __init__(self, packages: Mapping[str, Path]) -> None:
        self.nodes: list[StartedNode] = []
        self.parameters: dict[str, Any] = {}
        self.left_out: dict[str, str] = {}
        self.sources: list[Path] = []
        self.problems: list[str] = []
        self.robots: list[RobotSource] = []
        self.missing: list[tuple[str, Path]] = []
        self._packages = packages
        self._seen = 0
        self._files = 0
        self._tags: dict[str, Callable[[XmlElement, _Scope], None]] = {
            "arg": self._arg,
            "env": self._env,
            "group": self._group,
            "include": self._include,
            "node": self._node,
            "param": self._param,
            "remap": self._remap,
            "rosparam": self._rosparam,
        }

    def file(self, path: Path, scope: _Scope) -> None:
        """Read a file within a scope."""
        if scope.depth > _DEEPEST:
            raise RoslaunchError("launch files include each other without end")
        self._files += 1
        if self._files > _MOST_FILES:
            raise RoslaunchError(f"more than {_MOST_FILES} files are included")
        if not os.path.isfile(path):  # noqa: PTH113 - a name may be too long to be one of a file
            raise RoslaunchError(f"launch file '{path.name}' is not here")
        top = read_xml(read_text(path), path.name)
        self.sources.append(path)
        if top.tag != "launch":
            raise RoslaunchError(f"its top is <{top.tag}>, not <launch>")
        self._children(top, scope)

    def _children(self, element: XmlElement, scope: _Scope) -> None:
        for child in element.children:
            self._seen += 1
            if self._seen > _MOST_ELEMENTS:
                raise RoslaunchError(f"more than {_MOST_ELEMENTS} elements")
            read = self._tags.get(child.tag)
            if read is None:
                continue
            try:
                if self._counts(child, scope):
                    read(child, scope)
            except (RoslaunchError, ParameterTextError, RobotError) as error:
                self._problem(child, error)

    def _problem(self, element: XmlElement, error: Exception) -> None:
        line = f"{element.location}: <{element.tag}>: {error}"
        if line not in self.problems:
            self.problems.append(line)

    @staticmethod
    def _counts(element: XmlElement, scope: _Scope) -> bool:
        if "if" in element.attributes:
            return scope.texts.holds(element.attributes["if"])
        if "unless" in element.attributes:
            return not scope.texts.holds(element.attributes["unless"])
        return True

    def _arg(self, element: XmlElement, scope: _Scope) -> None:
        name, attributes = element.string("name"), element.attributes
        if "value" in attributes:
            scope.texts.arguments[name] = scope.texts.of(attributes["value"])
        elif name in scope.given:
            scope.texts.arguments[name] = scope.given[name]
        elif "default" in attributes:
            scope.texts.arguments[name] = scope.texts.of(attributes["default"])

    def _env(self, element: XmlElement, scope: _Scope) -> None:
        value = scope.texts.of(element.attributes.get("value", ""))
        scope.environment[element.string("name")] = value

    def _remap(self, element: XmlElement, scope: _Scope) -> None:
        old, new = (scope.texts.of(element.string(key)) for key in ("from", "to"))
        scope.remaps.append((old, new))

    def _group(self, element: XmlElement, scope: _Scope) -> None:
        # Arguments that a group sets are those of the whole file, as in roslaunch.
        self._children(element, scope.within(scope.texts.of(element.attributes.get("ns", ""))))

    def _include(self, element: XmlElement, scope: _Scope) -> None:
        path = Path(scope.texts.of(element.string("file")))
        inner = scope.within(scope.texts.of(element.attributes.get("ns", "")))
        given = Texts(self._packages, scope.texts.folder, dict(scope.texts.arguments))
        passed: dict[str, str] = {}
        if element.attributes.get("pass_all_args", "").lower() in ("true", "1"):
            passed.update(scope.texts.arguments)
        for child in element.children:
            if child.tag == "arg" and self._counts(child, scope):
                text = child.attributes.get("value", child.attributes.get("default", ""))
                passed[child.string("name")] = given.of(text)
            elif child.tag == "env":
                self._env(child, inner)
        self.file(
            path,
            replace(
                inner,
                texts=Texts(self._packages, path.parent),
                given=passed,
                depth=scope.depth + 1,
            ),
        )

    def _node(self, element: XmlElement, scope: _Scope) -> None:
        texts = scope.texts
        name = texts.of(element.string("name"))
        inner = scope.within(texts.of(element.attributes.get("ns", "")))
        owner = graph_names.join(inner.namespace, name)
        inner = replace(inner, owner=owner)
        # Remappings may stand behind the parameters, so that all of them are read first.
        self._children(element, inner)
        arguments = texts.of(element.attributes.get("args", ""))
        self.nodes.append(
            StartedNode(
                texts.of(element.string("pkg")),
                texts.of(element.string("type")),
                name,
                inner.namespace.rstrip("/"),
                arguments=tuple(_words(arguments)),
                remaps=tuple(inner.remaps),
                environment=tuple(sorted(inner.environment.items())),
            )
        )

    def _param(self, element: XmlElement, scope: _Scope) -> None:
        name = self._full_name(scope.texts.of(element.string("name")), scope)
        attributes, texts = element.attributes, scope.texts
        try:
            if "value" in attributes:
                value = typed(texts.of(attributes["value"]), attributes.get("type", "auto"))
            elif "textfile" in attributes:
                path = Path(texts.of(attributes["textfile"]))
                if is_robot_file(path):
                    self.robots.append(source_of_file(path))
                value = read_text(path)
                self.sources.append(path)
            elif "command" in attributes:
                # The program is not needed, and stands in no workspace.
                command = attributes["command"].replace("$(find xacro)/", "")
                try:
                    made = source_of_command(texts.of(command), texts.folder)
                except RoslaunchError as error:
                    made = source_of_problem(command, str(error))
                self.robots += [] if made is None else [made]
                raise RoslaunchError("the output of a command is not here")
            else:
                raise RoslaunchError("has no value, textfile or command")
        except (RoslaunchError, ParameterTextError) as error:
            self.left_out[name] = str(error)
            return
        self._set(name, value)

    def _rosparam(self, element: XmlElement, scope: _Scope) -> None:
        attributes, texts = element.attributes, scope.texts
        command = texts.of(attributes.get("command", "load"))
        space = texts.of(attributes.get("ns", "")).strip()
        given = texts.of(attributes.get("param", "")).strip()
        name = self._full_name("/".join(part for part in (space, given) if part), scope)
        if command == "delete":
            self._delete(name)
            return
        if command != "load":
            return
        try:
            if "file" in attributes:
                path = Path(texts.of(attributes["file"]))
                text = self._loaded(path, element)
            else:
                text = element.text
            if attributes.get("subst_value", "").lower() in ("true", "1"):
                text = texts.of(text)
            value = with_angles(yaml_value(text))
        except (RoslaunchError, ParameterTextError) as error:
            self.left_out[name] = str(error)
            raise
        if value is None:
            return
        if not isinstance(value, dict) and not given:
            raise RoslaunchError("holds a value without a name; give it 'param'")
        self._set(name, value)

    def _loaded(self, path: Path, element: XmlElement) -> str:
        try:
            text = read_text(path)
        except ParameterTextError as error:
            if isinstance(error.__cause__, FileNotFoundError):
                # A run depends on a file that is not there, too: it may come.
                self.sources.append(path)
                self.missing.append((str(element.location), path))
            raise
        self.sources.append(path)
        return text

    def _full_name(self, name: str, scope: _Scope) -> str:
        """Return the global name of a parameter: within a node all are its own."""
        if name.startswith("~"):
            # Outside of a node, `~` is a name below that of the node that is read next.
            name = name[1:].lstrip("/")
        if name.startswith("/"):
            return graph_names.canonical(name)
        space = scope.owner if scope.owner is not None else scope.namespace
        return (
            graph_names.canonical(graph_names.join(space, name))
            if name
            else graph_names.canonical(space)
        )

    def _set(self, name: str, value: Any) -> None:
        if isinstance(value, dict) and value:
            for key, inner in value.items():
                self._set(graph_names.canonical(f"{name.rstrip('/')}/{key}"), inner)
        elif not _is_storable(value):
            self.left_out[name] = f"the parameter server holds no {value!r}"
        else:
            # What is set later stands behind, as it would be sent.
            self.parameters.pop(name, None)
            self.parameters[name] = value

    def _delete(self, name: str) -> None:
        for parameter in list(self.parameters):
            if parameter == name or parameter.startswith(f"{name.rstrip('/')}/"):
                del self.parameters[parameter]


def _is_storable(value: Any) -> bool:
    """Return whether the parameter server holds a value: no `None`, no integer over 32 bits."""
    if isinstance(value, dict):
        return all(isinstance(key, str) and _is_storable(item) for key, item in value.items())
    if isinstance(value, list):
        return all(_is_storable(item) for item in value)
    if type(value) is int:
        return -_WIRE_LIMIT <= value < _WIRE_LIMIT
    return isinstance(value, bool | float | str)


def _words(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError:
        return text.split()
