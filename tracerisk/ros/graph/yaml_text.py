"""YAML as the Python libraries of ROS read it: version 1.1 as PyYAML has it.

`yes` and `on` are true and `010` is eight, but `y` and `n` are texts: a parameter may be named so.
The later of two equal keys counts.
"""

from __future__ import annotations

import warnings
from typing import Any

_BOOL, _STR = "tag:yaml.org,2002:bool", "tag:yaml.org,2002:str"


def load_yaml(text: str) -> Any:
    """Return the value of a YAML text of one document; None of an empty one.

    Raises:
        ruamel.yaml.error.YAMLError: it is not YAML.
    """
    from tracerisk.text.yaml_bounds import bounded_yaml

    root = bounded_yaml("safe", (1, 1)).compose(text)
    return None if root is None else _constructed(root)


def _constructed(root: Any) -> Any:
    from ruamel.yaml.error import YAMLError

    from tracerisk.text.yaml_bounds import bounded_yaml

    yaml = bounded_yaml("safe", (1, 1))
    yaml.allow_duplicate_keys = True
    _keep_texts(root, set())
    with warnings.catch_warnings():
        # `1e3`, which YAML 1.1 wants written `1.0e3`.
        warnings.simplefilter("ignore")
        try:
            return yaml.constructor.construct_document(root)
        except (TypeError, ValueError) as error:
            # Keys that are mappings, dates that are none.
            raise YAMLError(str(error)) from error


def load_sections(text: str) -> list[tuple[Any, Any]] | None:
    """Return keys and values of a YAML text that is a mapping; None of another.

    A key that comes twice is there twice: a file of parameters may name a node again.

    Raises:
        ruamel.yaml.error.YAMLError: it is not YAML.
    """
    from ruamel.yaml.nodes import MappingNode

    from tracerisk.text.yaml_bounds import bounded_yaml

    root = bounded_yaml("safe", (1, 1)).compose(text)
    if not isinstance(root, MappingNode):
        return None
    return [(key.value, _constructed(value)) for key, value in root.value]


def _keep_texts(node: Any, seen: set[int]) -> None:
    """Make texts of keys that would be truth values and of plain `y` and `n`; drop former keys."""
    from ruamel.yaml.nodes import MappingNode

    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node.value, str):
        if str(node.tag) == _BOOL and node.value.lower() in ("y", "n"):
            node.tag = _STR
        return
    if isinstance(node, MappingNode):
        latest = {_name(key, at): at for at, (key, _) in enumerate(node.value)}
        node.value = [node.value[at] for at in sorted(latest.values())]
    for item in node.value:
        if not isinstance(item, tuple):
            _keep_texts(item, seen)
            continue
        key, value = item
        if str(key.tag) == _BOOL:
            key.tag = _STR
        _keep_texts(key, seen)
        _keep_texts(value, seen)


def _name(key: Any, at: int) -> Any:
    # Merges, and keys that are no scalars, are all kept.
    is_one = isinstance(key.value, str) and not str(key.tag).endswith(":merge")
    return (str(key.tag), key.value) if is_one else at
