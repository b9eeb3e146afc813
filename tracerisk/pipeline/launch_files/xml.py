"""ROS 2 launch files of XML and YAML as actions: one tree of elements, one table of tags."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tracerisk.pipeline.launch_files.parameter_text import yaml_value
from tracerisk.pipeline.launch_files.stand_ins.launch import actions, conditions
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_description import LaunchDescription
from tracerisk.pipeline.launch_files.stand_ins.launch_ros import actions as ros
from tracerisk.pipeline.launch_files.stand_ins.launch_ros.parameter_descriptions import (
    ParameterFile,
    ParameterValue,
)
from tracerisk.pipeline.launch_files.texts import LaunchTextError, substitutions_of, words_of
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

_TYPES: dict[str, Any] = {
    "bool": bool,
    "float": float,
    "int": int,
    "str": str,
    "list_of_bool": list[bool],
    "list_of_float": list[float],
    "list_of_int": list[int],
    "list_of_str": list[str],
}


@dataclass(slots=True)
class Element:
    """An entity of a launch file."""

    tag: str
    """The tag, such as `node`."""
    attributes: dict[str, Any]
    """The values by name: text from XML, plain values from YAML."""
    children: list[Element] = field(default_factory=list)
    """The entities inside, in the order of the file."""

    def all(self, tag: str) -> list[Element]:
        """Return the children with a tag."""
        return [child for child in self.children if child.tag == tag]

    def text(self, name: str) -> str:
        """Return an attribute as text; raise LaunchTextError when it is missing."""
        if name not in self.attributes:
            raise LaunchTextError(f"<{self.tag}> has no '{name}'")
        return _as_text(self.attributes[name])

    def get(self, name: str) -> list[Any] | None:
        """Return the substitutions of an attribute, None where it is absent."""
        return substitutions_of(self.text(name)) if name in self.attributes else None

    def need(self, name: str) -> list[Any]:
        """Return the substitutions of an attribute; raise LaunchTextError when it is missing."""
        return substitutions_of(self.text(name))

    def words(self, name: str) -> list[list[Any]]:
        """Return the words of an attribute, each with its substitutions; none without it."""
        return words_of(self.text(name)) if name in self.attributes else []

    def flag(self, name: str, *, default: bool) -> bool:
        """Return a truth value that is written out."""
        text = _as_text(self.attributes.get(name, default)).strip().lower()
        if text not in ("true", "false", "1", "0"):
            raise LaunchTextError(f"'{name}' of <{self.tag}> is neither true nor false")
        return text in ("true", "1")


def description_of_xml(text: str, file: str) -> LaunchDescription:
    """Return the description that an XML launch file of ROS 2 holds."""
    return _description(_of_xml(read_xml(text, file)))


def description_of_yaml(text: str) -> LaunchDescription:
    """Return the description that a YAML launch file holds."""
    content = yaml_value(text)
    if not isinstance(content, dict) or "launch" not in content:
        raise LaunchTextError("holds no 'launch:'")
    return _description(_of_yaml("launch", content["launch"]))


def _of_xml(element: XmlElement) -> Element:
    children = [_of_xml(child) for child in element.children]
    return Element(element.tag, dict(element.attributes), children)


def _of_yaml(tag: str, content: Any) -> Element:
    """Return an entity: keys that hold entities are children, all others attributes."""
    if isinstance(content, list):
        if not all(isinstance(item, dict) for item in content if item):
            raise LaunchTextError(f"'{tag}' lists what is no entity; write `- name: ...`")
        return Element(tag, {}, [_of_yaml(*next(iter(item.items()))) for item in content if item])
    if content is not None and not isinstance(content, dict):
        raise LaunchTextError(f"'{tag}' is no mapping; its attributes are `name: value`")
    element = Element(str(tag), {})
    for key, value in (content or {}).items():
        name = str(key)
        if name == "children" and isinstance(value, list):
            element.children += _of_yaml(tag, value).children
        elif isinstance(value, list) and all(isinstance(item, dict) for item in value):
            element.children += [_of_yaml(name, item) for item in value]
        else:
            element.attributes[name] = value
    return element


def _as_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def _description(top: Element) -> LaunchDescription:
    if top.tag != "launch":
        raise LaunchTextError(f"its top is <{top.tag}>, not <launch>")
    return LaunchDescription(_actions(top))


def _actions(element: Element) -> list[Any]:
    return [_Later(child) for child in element.children]


class _Later(actions.OpaqueFunction):
    """An entity that is made of its element when it is visited: a bad one spoils no other."""

    def __init__(self, element: Element) -> None:
        super().__init__(function=self._make)
        self.element = element

    def describe(self) -> str:
        """Return the tag."""
        return f"<{self.element.tag}>"

    def _make(self, _context: Any) -> list[Any]:
        element, tag = self.element, self.element.tag.replace("-", "_")
        if tag in _LEFT_OUT:
            return []
        if tag in _PLAIN:
            kind, *names = _PLAIN[tag]
            made = partial(kind, *(element.need(name) for name in names))
        elif tag in _TAGS:
            made = _TAGS[tag](element)
        else:
            raise LaunchTextError(f"<{element.tag}> is not read")
        return [made(**_condition(element))]


def _condition(element: Element) -> dict[str, Any]:
    if "if" in element.attributes:
        return {"condition": conditions.IfCondition(element.need("if"))}
    if "unless" in element.attributes:
        return {"condition": conditions.UnlessCondition(element.need("unless"))}
    return {}


def _arg(element: Element) -> Any:
    name, default = element.text("name"), element.get("default")
    return partial(actions.DeclareLaunchArgument, name, default_value=default)


def _group(element: Element) -> Any:
    inner = Element(element.tag, {}, [child for child in element.children if child.tag != "keep"])
    kept = {tuple(item.need("name")): item.need("value") for item in element.all("keep")}
    return partial(
        actions.GroupAction,
        _actions(inner),
        scoped=element.flag("scoped", default=True),
        forwarding=element.flag("forwarding", default=True),
        launch_configurations=kept,
    )


def _include(element: Element) -> Any:
    given = [*element.all("arg"), *element.all("let")]
    return partial(
        actions.IncludeLaunchDescription,
        element.need("file"),
        launch_arguments=[(item.need("name"), item.need("value")) for item in given],
    )


def _environment(element: Element) -> list[tuple[Any, Any]]:
    return [(item.text("name"), item.need("value")) for item in element.all("env")]


def _node(element: Element) -> Any:
    return partial(
        ros.Node,
        executable=element.need("exec"),
        package=element.get("pkg"),
        name=element.get("name"),
        namespace=element.get("namespace"),
        parameters=[part for item in element.all("param") for part in _parameters(item)],
        remappings=[(item.need("from"), item.need("to")) for item in element.all("remap")],
        arguments=element.words("args"),
        ros_arguments=element.words("ros_args"),
        additional_env=dict(_environment(element)),
    )


def _parameters(element: Element) -> list[Any]:
    if "from" in element.attributes:
        substituted = element.flag("allow_substs", default=False)
        return [ParameterFile(element.need("from"), allow_substs=substituted)]
    return [_tree(element)]


def _tree(element: Element) -> dict[str, Any]:
    name = element.text("name")
    inner = element.all("param")
    if inner:
        table: dict[str, Any] = {}
        for item in inner:
            table.update(_tree(item))
        return {name: table}
    value = element.attributes.get("value")
    if value is not None and not isinstance(value, str):
        return {name: value}
    kind = element.attributes.get("type")
    if kind is not None and kind not in _TYPES:
        raise LaunchTextError(f"<{element.tag}> has the unknown type '{kind}'")
    separator = element.attributes.get("value-sep", element.attributes.get("sep"))
    if separator is not None:
        parts = [part.strip() for part in element.text("value").split(separator)]
        return {name: [yaml_value(part) for part in parts]}
    return {name: ParameterValue(element.need("value"), value_type=_TYPES.get(kind or ""))}


def _executable(element: Element) -> Any:
    words, environment = words_of(element.text("cmd")), dict(_environment(element))
    return partial(actions.ExecuteProcess, cmd=words, additional_env=environment)


def _set_parameter(element: Element) -> Any:
    value = element.attributes.get("value")
    given = value if value is not None and not isinstance(value, str) else None
    made = given if given is not None else ParameterValue(element.need("value"))
    return partial(ros.SetParameter, element.need("name"), made)


def _timer(element: Element) -> Any:
    period = element.get("period") or "0"
    return partial(actions.TimerAction, period=period, actions=_actions(element))


_PLAIN: dict[str, tuple[Any, ...]] = {
    "let": (actions.SetLaunchConfiguration, "name", "value"),
    "push_ros_namespace": (ros.PushRosNamespace, "namespace"),
    "set_parameters_from_file": (ros.SetParametersFromFile, "filename"),
    "set_remap": (ros.SetRemap, "from", "to"),
    "set_env": (actions.SetEnvironmentVariable, "name", "value"),
    "unset_env": (actions.UnsetEnvironmentVariable, "name"),
}
"""Actions that are made of attributes as they stand, in this order."""
_TAGS: dict[str, Callable[[Element], Any]] = {
    "arg": _arg,
    "group": _group,
    "include": _include,
    "node": _node,
    "executable": _executable,
    "set_parameter": _set_parameter,
    "set_use_sim_time": lambda element: partial(
        ros.SetUseSimTime, ParameterValue(element.need("value"))
    ),
    "timer": _timer,
}
"""What makes the others; each lacks its condition."""
_LEFT_OUT = frozenset(
    {"reset", "keep", "log", "shutdown", "node_container", "load_composable_node"}
)
