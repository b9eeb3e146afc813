"""ROS 2 launch files of XML and YAML as actions: one tree of elements, one table of tags."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
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
    """An entity of a launch file: its tag, its attributes, its children."""

    tag: str
    attributes: dict[str, Any]
    children: list[Element] = field(default_factory=list)

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
        return Element(tag, {}, [_of_yaml(*next(iter(each.items()))) for each in content if each])
    element = Element(tag, {})
    for key, value in (content or {}).items():
        name = str(key)
        if name == "children" and isinstance(value, list):
            element.children += _of_yaml(tag, value).children
        elif isinstance(value, list) and all(isinstance(each, dict) for each in value):
            element.children += [_of_yaml(name, each) for each in value]
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
        tag = self.element.tag.replace("-", "_")
        if tag not in _TAGS:
            raise LaunchTextError(f"<{self.element.tag}> is not read")
        made = _TAGS[tag](self.element)
        return [] if made is None else [made]


def _condition(element: Element) -> dict[str, Any]:
    if "if" in element.attributes:
        return {"condition": conditions.IfCondition(element.need("if"))}
    if "unless" in element.attributes:
        return {"condition": conditions.UnlessCondition(element.need("unless"))}
    return {}


def _arg(element: Element) -> Any:
    return actions.DeclareLaunchArgument(
        element.text("name"), default_value=element.get("default"), **_condition(element)
    )


def _let(element: Element) -> Any:
    return actions.SetLaunchConfiguration(
        element.need("name"), element.need("value"), **_condition(element)
    )


def _group(element: Element) -> Any:
    inner = Element(element.tag, {}, [each for each in element.children if each.tag != "keep"])
    kept = {tuple(each.need("name")): each.need("value") for each in element.all("keep")}
    return actions.GroupAction(
        _actions(inner),
        scoped=element.flag("scoped", default=True),
        forwarding=element.flag("forwarding", default=True),
        launch_configurations=kept,
        **_condition(element),
    )


def _include(element: Element) -> Any:
    given = [*element.all("arg"), *element.all("let")]
    return actions.IncludeLaunchDescription(
        element.need("file"),
        launch_arguments=[(each.need("name"), each.need("value")) for each in given],
        **_condition(element),
    )


def _environment(element: Element) -> list[tuple[Any, Any]]:
    return [(each.text("name"), each.need("value")) for each in element.all("env")]


def _node(element: Element) -> Any:
    return ros.Node(
        executable=element.need("exec"),
        package=element.get("pkg"),
        name=element.get("name"),
        namespace=element.get("namespace"),
        parameters=[part for each in element.all("param") for part in _parameters(each)],
        remappings=[(each.need("from"), each.need("to")) for each in element.all("remap")],
        arguments=words_of(element.text("args")) if "args" in element.attributes else (),
        ros_arguments=words_of(element.text("ros_args"))
        if "ros_args" in element.attributes
        else (),
        additional_env=dict(_environment(element)),
        **_condition(element),
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
        found: dict[str, Any] = {}
        for each in inner:
            found.update(_tree(each))
        return {name: found}
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
    return actions.ExecuteProcess(
        cmd=words_of(element.text("cmd")),
        additional_env=dict(_environment(element)),
        **_condition(element),
    )


def _namespace(element: Element) -> Any:
    return ros.PushRosNamespace(element.need("namespace"), **_condition(element))


def _set_parameter(element: Element) -> Any:
    value = element.attributes.get("value")
    given = value if value is not None and not isinstance(value, str) else None
    made = given if given is not None else ParameterValue(element.need("value"))
    return ros.SetParameter(element.need("name"), made, **_condition(element))


def _timer(element: Element) -> Any:
    return actions.TimerAction(
        period=element.get("period") or "0", actions=_actions(element), **_condition(element)
    )


def _nothing(_element: Element) -> Any:
    return None


_TAGS: dict[str, Callable[[Element], Any]] = {
    "arg": _arg,
    "let": _let,
    "group": _group,
    "include": _include,
    "node": _node,
    "executable": _executable,
    "push_ros_namespace": _namespace,
    "set_parameter": _set_parameter,
    "set_parameters_from_file": lambda each: ros.SetParametersFromFile(
        each.need("filename"), **_condition(each)
    ),
    "set_remap": lambda each: ros.SetRemap(each.need("from"), each.need("to"), **_condition(each)),
    "set_use_sim_time": lambda each: ros.SetUseSimTime(
        ParameterValue(each.need("value")), **_condition(each)
    ),
    "set_env": lambda each: actions.SetEnvironmentVariable(
        each.need("name"), each.need("value"), **_condition(each)
    ),
    "unset_env": lambda each: actions.UnsetEnvironmentVariable(
        each.need("name"), **_condition(each)
    ),
    "timer": _timer,
    "reset": _nothing,
    "keep": _nothing,
    "log": _nothing,
    "shutdown": _nothing,
    "node_container": _nothing,
    "load_composable_node": _nothing,
}
