"""Keys that come twice in one mapping of YAML, as the software of ROS reads them.

The readers of our own files refuse them.
"""

from __future__ import annotations

from typing import Any

OF_NODE = "ros__parameters"
"""The key below which a parameter file of ROS 2 has the parameters of a node."""


def fold_repeated(root: Any) -> None:
    """Leave each key once in the mappings of a composed text.

    In a parameter file of ROS 2 the mappings of one key are joined, and of other values the later
    counts (ros2/rcl rcl_yaml_param_parser/src/parse.c, `find_node` and `find_parameter`). In any
    other text the later counts alone, as for PyYAML.
    """
    _fold(root, set(), joins=_names_nodes(root, set()))


def _names_nodes(node: Any, seen: set[int]) -> bool:
    if not _is_mapping(node) or id(node) in seen:
        return False
    seen.add(id(node))
    return any(key.value == OF_NODE or _names_nodes(value, seen) for key, value in node.value)


def _fold(node: Any, seen: set[int], *, joins: bool) -> None:
    if isinstance(node.value, str) or id(node) in seen:
        return
    seen.add(id(node))
    if not _is_mapping(node):
        for item in node.value:
            _fold(item, seen, joins=joins)
        return
    latest: dict[Any, tuple[Any, Any]] = {}
    for at, (key, value) in enumerate(node.value):
        name = _name(key, at)
        first, before = latest.get(name, (key, None))
        is_joined = joins and _is_mapping(before) and _is_mapping(value)
        latest[name] = (first, _joined(before, value)) if is_joined else (key, value)
    node.value = list(latest.values())
    for key, value in node.value:
        _fold(key, seen, joins=joins)
        _fold(value, seen, joins=joins)


def _joined(one: Any, other: Any) -> Any:
    """Return a mapping with the entries of two: one that an alias names stays as it is."""
    return type(one)(
        one.tag,
        [*one.value, *other.value],
        start_mark=one.start_mark,
        end_mark=other.end_mark,
        flow_style=one.flow_style,
    )


def _is_mapping(node: Any) -> bool:
    from ruamel.yaml.nodes import MappingNode

    return isinstance(node, MappingNode)


def _name(key: Any, at: int) -> Any:
    # Merges, and keys that are no scalars, are all kept.
    is_one = isinstance(key.value, str) and not str(key.tag).endswith(":merge")
    return (str(key.tag), key.value) if is_one else at
