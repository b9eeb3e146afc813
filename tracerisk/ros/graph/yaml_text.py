"""YAML as the Python libraries of ROS read it: version 1.1 as PyYAML has it.

`yes` and `on` are true and `010` is eight, but `y` and `n` are texts: a parameter may be named so.
Of two equal keys the later counts; in a parameter file of ROS 2 what they hold is joined.
"""

from __future__ import annotations

import warnings
from copy import deepcopy
from functools import lru_cache
from typing import Any

from tracerisk.common.text.yaml_repeated_keys import fold_repeated

_BOOL, _STR = "tag:yaml.org,2002:bool", "tag:yaml.org,2002:str"


def load_yaml(text: str) -> Any:
    """Return the value of a YAML text of one document; None of an empty one.

    Raises:
        ruamel.yaml.error.YAMLError: it is not YAML.
    """
    return deepcopy(_loaded(text))


# Launch files of one workspace load the same files again and again.
@lru_cache(maxsize=512)
def _loaded(text: str) -> Any:
    from ruamel.yaml.error import YAMLError

    from tracerisk.common.text.yaml_bounds import bounded_yaml

    root = bounded_yaml("safe", (1, 1)).compose(text)
    if root is None:
        return None
    yaml = bounded_yaml("safe", (1, 1))
    yaml.allow_duplicate_keys = True  # `1` and `01`, which are two as texts
    fold_repeated(root)
    _keep_texts(root, set())
    with warnings.catch_warnings():
        # `1e3`, which YAML 1.1 wants written `1.0e3`.
        warnings.simplefilter("ignore")
        try:
            return yaml.constructor.construct_document(root)
        except (TypeError, ValueError) as error:
            # Keys that are mappings, dates that are none.
            raise YAMLError(str(error)) from error


def _keep_texts(node: Any, seen: set[int]) -> None:
    """Make texts of keys that would be truth values and of plain `y` and `n`."""
    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node.value, str):
        if str(node.tag) == _BOOL and node.value.lower() in ("y", "n"):
            node.tag = _STR
        return
    for item in node.value:
        if not isinstance(item, tuple):
            _keep_texts(item, seen)
            continue
        key, value = item
        if str(key.tag) == _BOOL:
            key.tag = _STR
        _keep_texts(key, seen)
        _keep_texts(value, seen)
