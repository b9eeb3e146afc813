"""Parameters as they are written: texts of YAML 1.1, and the files of either ROS."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import file_text
from tracerisk.common.text.yaml_repeated_keys import OF_NODE
from tracerisk.pipeline.launch_files.expressions import evaluate
from tracerisk.pipeline.launch_files.records import EVERY_NODE, LaunchParameter
from tracerisk.ros.graph.yaml_text import load_yaml

_MOST_BYTES = 4 * 1024 * 1024
_MOST_YAML = 256 * 1024  # characters; seconds
_MOST_VALUES = 50_000  # aliases make many of few
_EVERY = frozenset({"/**", "/*", "**", "*", ""})
_ANGLE = re.compile(r"(deg|rad)\(([^()]*)\)")


class ParameterTextError(ValueError):
    """A text is not YAML, or no file of parameters."""


def yaml_value(text: str) -> Any:
    """Return the value of a YAML text, as ROS reads it: by YAML 1.1, `yes` is true.

    Raises ParameterTextError when it is none.
    """
    from ruamel.yaml.error import YAMLError

    if len(text) > _MOST_YAML:
        raise ParameterTextError(f"has more than {_MOST_YAML} characters")
    try:
        value = load_yaml(text)
    except (YAMLError, ValueError, RecursionError) as error:
        reason = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise ParameterTextError(f"is not YAML: {reason}") from error
    _forbid_many(value)
    return value


def _forbid_many(value: Any) -> None:
    """Raise ParameterTextError where a value holds too many others, or itself."""
    waiting, count = [value], 0
    while waiting:
        each = waiting.pop()
        count += 1
        if count > _MOST_VALUES:
            raise ParameterTextError(f"holds more than {_MOST_VALUES} values")
        if isinstance(each, dict):
            waiting += each.values()
        elif isinstance(each, list):
            waiting += each


def read_text(path: Path) -> str:
    """Return the text of a file.

    Raises ParameterTextError when it is too large or cannot be read.
    """
    try:
        if path.exists() and not path.is_file():
            raise ParameterTextError("is not a file")
        if path.stat().st_size > _MOST_BYTES:
            raise ParameterTextError(f"is larger than {_MOST_BYTES} bytes")
        return file_text(path, errors="replace")
    except OSError as error:
        raise ParameterTextError(f"cannot be read: {error.strerror}") from error


def node_parameters(content: Any) -> tuple[LaunchParameter, ...]:
    """Return the parameters of a file of ROS 2, node by node, dots between the parts of names.

    Raises ParameterTextError where a node has no `ros__parameters`.
    """
    if content is None:
        return ()
    if not isinstance(content, dict):
        raise ParameterTextError("is not a file of parameters: it holds no mapping")
    return tuple(_walk(content, ""))


def _walk(tree: dict[Any, Any], space: str) -> Iterator[LaunchParameter]:
    for key, inner in tree.items():
        if key == OF_NODE:
            node = EVERY_NODE if space.strip("/") in _EVERY else space
            for name, value in flat(inner or {}):
                yield LaunchParameter(node, name, value)
        elif isinstance(inner, dict):
            yield from _walk(inner, f"{space}/{str(key).strip('/')}")
        else:
            where = space or "the file"
            raise ParameterTextError(f"'{key}' of {where} stands outside of '{OF_NODE}'")


def flat(tree: Any, prefix: str = "", mark: str = ".") -> Iterator[tuple[str, Any]]:
    """Yield the leaves of a tree, those without a value left out, with their joined names."""
    if not isinstance(tree, dict):
        raise ParameterTextError(f"'{OF_NODE}' holds no mapping")
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}{mark}", mark)
        elif is_storable(value):
            yield f"{prefix}{key}", value


def is_storable(value: Any) -> bool:
    """Return whether a value is one that a parameter can have."""
    if isinstance(value, list | tuple):
        return all(is_storable(item) for item in value)
    return isinstance(value, bool | int | float | str)


def with_angles(value: Any) -> Any:
    """Return a value of a ROS 1 file with its `deg(90)` and `rad(pi/2)` as numbers."""
    if isinstance(value, dict):
        return {str(key): with_angles(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [with_angles(inner) for inner in value]
    if isinstance(value, str) and (matched := _ANGLE.fullmatch(value.strip())):
        try:
            number = float(evaluate(matched[2], {}))
        except ValueError:
            return value
        return math.radians(number) if matched[1] == "deg" else number
    return value
