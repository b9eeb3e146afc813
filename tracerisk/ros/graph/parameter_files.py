"""Parameters of files: as `rosparam load` reads them, and as ROS 2 does, node by node."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from tracerisk.common.text.yaml_reader import YamlMap, read_yaml
from tracerisk.common.text.yaml_repeated_keys import OF_NODE
from tracerisk.errors import Location, ScenarioError
from tracerisk.ros.graph.parameters import ParameterTree

EVERY_NODE = "/**"
_EVERY = frozenset({EVERY_NODE, "/*", "**", "*"})


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter and where it is set."""

    node: str | None
    """The node that it belongs to, or a pattern of nodes; `None`: every node."""
    name: str
    """The name of the parameter; a leading `~` makes it private to the node."""
    value: Any
    """The value, as YAML holds it."""
    location: Location | None = None
    """The line that sets it; `None` where it comes from no file."""


def read_parameters(path: Path) -> tuple[Parameter, ...]:
    """Read a parameter file of either ROS, which is YAML 1.1 as both read it: `yes` is true.

    A key may come twice: `fold_repeated`.

    Raises:
        ScenarioError: it cannot be read, or holds no mapping, or a value no parameter can have.
    """
    return parameters_of(read_yaml(path, ScenarioError, version=(1, 1), may_repeat=True))


def parameters_of(tree: YamlMap) -> tuple[Parameter, ...]:
    """Return the parameters of a mapping.

    Below `ros__parameters` they are those of the node that the keys above it name. All others
    are everybody's, and a key that begins with `~` is private to the node.

    Raises:
        ScenarioError: a value is none that a parameter can have.
    """
    return tuple(_walk(tree, ""))


def _walk(tree: YamlMap, space: str) -> Iterator[Parameter]:
    keys = tree.keys()
    for key in keys:
        value = tree.get(key)
        if key == OF_NODE:
            yield from _of_node(tree.map(key), space)
        elif isinstance(value, dict) and _names_nodes(value):
            yield from _walk(tree.map(key), f"{space.rstrip('/')}/{key.strip('/')}")
        else:
            _check(tree, key, value)
            place = tree.key_location(key)
            yield Parameter(None, _joined(space, key), plain(value), place)


def _of_node(values: YamlMap, space: str) -> Iterator[Parameter]:
    node = EVERY_NODE if space.strip("/") in _EVERY or not space else space
    keys = values.keys()
    for key in keys:
        value = values.get(key)
        _check(values, key, value)
        for name, inner in flat(key, plain(value)):
            yield Parameter(node, name, inner, values.key_location(key))


def _names_nodes(tree: dict[str, Any]) -> bool:
    return OF_NODE in tree or any(
        isinstance(inner, dict) and _names_nodes(inner) for inner in tree.values()
    )


def _joined(space: str, key: str) -> str:
    return key if not space or key.startswith("~") else f"{space}/{key.lstrip('/')}"


def flat(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield each value within mappings, with its dotted name."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, inner in value.items():
        yield from flat(f"{name}.{key}", inner)


def _check(tree: YamlMap, key: str, value: Any) -> None:
    if value is None:
        tree.fail(key, "has no value; give it one")
    if isinstance(value, dict):
        inner = tree.map(key)
        names = inner.keys()
        for name in names:
            _check(inner, name, inner.get(name))
        return
    try:
        ParameterTree().set("/value", plain(value))
    except (TypeError, OverflowError):
        tree.fail(
            key,
            f"cannot hold {_unfit(value)}; allowed: true or false, numbers (whole ones of 32 "
            "bits), strings, binary data, lists and mappings",
        )


def _unfit(value: Any) -> str:
    """Return what of a value no parameter can be, as users call it."""
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return next((unfit for item in value if (unfit := _unfit(item))), "")
    if isinstance(value, Set):
        return "a set (!!set)"
    if isinstance(value, date):
        return f"the date {value}; put it in quotes if it is a string"
    if value is None:
        return "an entry without a value"
    if isinstance(value, int) and not -(2**31) <= value < 2**31:
        return "a whole number of more than 32 bits"
    if isinstance(value, bool | int | float | str | bytes):
        return ""
    return f"a value of the type {getattr(value, 'tag', None) or type(value).__name__}"


def into_tree(parameters: tuple[Parameter, ...], tree: ParameterTree) -> None:
    """Set the parameters that are not private to a node on the parameter server."""
    for parameter in parameters:
        if parameter.node is None and not parameter.name.startswith("~"):
            _merge(tree, f"/{parameter.name.lstrip('/')}", parameter.value)
        elif parameter.node not in (None, EVERY_NODE):
            _merge(tree, f"{parameter.node}/{parameter.name.replace('.', '/')}", parameter.value)


def private_of(parameters: tuple[Parameter, ...]) -> tuple[tuple[str, Any], ...]:
    """Return the parameters that a node of ROS 1 finds under its own name, whatever that is.

    Of two with one name the later counts.
    """
    table = {
        parameter.name.lstrip("~").lstrip("/").replace(".", "/"): parameter.value
        for parameter in parameters
        if parameter.node == EVERY_NODE
        or (parameter.node is None and parameter.name.startswith("~"))
    }
    return tuple(table.items())


def write_overrides(parameters: tuple[Parameter, ...], path: Path) -> str | None:
    """Write a parameter file of ROS 2 of what is set for nodes; return its path, None for none."""
    nodes: dict[str, dict[str, Any]] = {}
    for node, name, value in overrides_of(parameters):
        if value not in (None, []):  # neither has a type, and rcl refuses them
            nodes.setdefault(node or EVERY_NODE, {})[name] = value
    if not nodes:
        return None
    # JSON is YAML; what is everybody's comes first, for the last one counts.
    ordered = sorted(nodes, key=lambda node: (node != EVERY_NODE, node))
    content = {node: {"ros__parameters": nodes[node]} for node in ordered}
    path.write_text(json.dumps(content), encoding="utf-8")
    return str(path)


def overrides_of(parameters: tuple[Parameter, ...]) -> tuple[tuple[str | None, str, Any], ...]:
    """Return what the parameters set for nodes of ROS 2: node (None: all), dotted name, value.

    A name such as `/pick/speed` is that of the node `/pick` as well as everybody's `pick.speed`.
    """
    overrides: list[tuple[str | None, str, Any]] = []
    for parameter in parameters:
        if parameter.node is not None:
            node = None if parameter.node == EVERY_NODE else parameter.node
            overrides.append((node, parameter.name, parameter.value))
            continue
        name = parameter.name.lstrip("~").strip("/")
        for dotted, value in flat(name.replace("/", "."), parameter.value):
            overrides.append((None, dotted, value))
        space, slash, last = name.rpartition("/")
        if slash:
            overrides += [
                (f"/{space}", dotted, value) for dotted, value in flat(last, parameter.value)
            ]
    return tuple(overrides)


def _merge(tree: ParameterTree, name: str, value: Any) -> None:
    """Set a parameter; a dictionary leaves what else its namespace holds."""
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            _merge(tree, f"{name}/{key}", inner)
    else:
        tree.set(name, value)


def plain(value: Any) -> Any:
    """Return a value of a YAML file without the positions that ruamel keeps with it."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [plain(inner) for inner in value]
    for kind in (bool, int, float, str):
        if isinstance(value, kind):
            return kind(value)
    return value
