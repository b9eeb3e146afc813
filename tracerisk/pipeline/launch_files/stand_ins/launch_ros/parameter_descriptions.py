"""`launch_ros.parameter_descriptions`, and what parameters of nodes come to."""

from __future__ import annotations

import os
import typing
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.parameter_text import (
    ParameterTextError,
    is_storable,
    node_parameters,
    read_text,
    yaml_value,
)
from tracerisk.pipeline.launch_files.placeholders import Absent, AbsentError
from tracerisk.pipeline.launch_files.records import EVERY_NODE, LaunchParameter
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of

Found = tuple[list[LaunchParameter], list[tuple[str, str]]]
"""The parameters, and the names of those left out, each with its reason."""


class ParameterValue:
    """A value, with the type that its text is to have."""

    def __init__(self, value: Any, *, value_type: Any = None) -> None:
        self.value, self.value_type = value, value_type

    def evaluate(self, context: Any) -> Any:
        """Return the value.

        Raises:
            ValueError: its text is none of that type.
        """
        if not isinstance(self.value, str | Substitution | Absent | Sequence):
            return self.value
        text = _text_or_list(context, self.value)
        return _typed(text, self.value_type)


class Parameter:
    """A name and a value."""

    def __init__(self, name: Any, value: Any, *, value_type: Any = None) -> None:
        self.name = name
        self.value = ParameterValue(value, value_type=value_type)

    def evaluate(self, context: Any) -> tuple[str, Any]:
        """Return the name and the value."""
        return text_of(context, self.name), self.value.evaluate(context)


class ParameterFile:
    """A file of parameters, in which substitutions may stand."""

    def __init__(self, param_file: Any, *, allow_substs: Any = False) -> None:
        self.param_file, self.allow_substs = param_file, allow_substs

    def evaluate(self, context: Any) -> Path:
        """Return its path."""
        return Path(text_of(context, self.param_file))


def evaluate_parameters(context: Any, given: Any) -> Found:
    """Return what the `parameters` of a node come to."""
    parameters: Found = ([], [])
    if isinstance(given, Absent):
        parameters[1].append(("*", f"{given.words} is not here"))
        return parameters
    if isinstance(given, Mapping | str | Substitution):
        given = [given]
    for parameter in given or ():
        if isinstance(parameter, Absent):
            parameters[1].append(("*", f"{parameter.words} is not here"))
        elif isinstance(parameter, Mapping):
            _of_mapping(context, parameter, "", parameters)
        elif isinstance(parameter, Parameter):
            _put(context, parameter.name, parameter.value, "", parameters)
        elif parameter is not None:
            _of_file(context, parameter, parameters)
    return parameters


def _of_mapping(context: Any, tree: Mapping[Any, Any], prefix: str, found: Found) -> None:
    for name, value in tree.items():
        if isinstance(value, Mapping):
            _of_mapping(context, value, f"{prefix}{text_of(context, name)}.", found)
        else:
            _put(context, name, value, prefix, found)


def _put(context: Any, name: Any, value: Any, prefix: str, found: Found) -> None:
    full = prefix + text_of(context, name)
    try:
        evaluated = _value(context, value)
    except (AbsentError, RuntimeError, ValueError, TypeError) as error:
        found[1].append((full, str(error)))
        return
    if is_storable(evaluated):
        found[0].append(LaunchParameter(EVERY_NODE, full, evaluated))
    else:
        found[1].append((full, f"{type(evaluated).__name__} is not a type of a parameter"))


def _value(context: Any, value: Any) -> Any:
    if isinstance(value, Absent):
        raise AbsentError(f"{value.words} is not here")
    if isinstance(value, ParameterValue):
        return value.evaluate(context)
    if isinstance(value, Substitution):
        return _of_yaml(text_of(context, value))
    if isinstance(value, str | bool | int | float | bytes) or not isinstance(value, Sequence):
        return value
    if any(isinstance(item, Substitution) for item in value) and all(
        isinstance(item, str | Substitution) for item in value
    ):
        # Parts of one text.
        return _of_yaml(text_of(context, value))
    return _uniform([_value(context, item) if _is_text(item) else item for item in value])


def _is_text(value: Any) -> bool:
    return isinstance(value, Substitution | Absent) or (
        isinstance(value, Sequence) and not isinstance(value, str | bytes)
    )


def _uniform(values: list[Any]) -> list[Any]:
    kinds = {type(value) for value in values}
    return [float(value) for value in values] if kinds == {int, float} else values


def _of_yaml(text: str) -> Any:
    return yaml_value(text) if text else ""


def _text_or_list(context: Any, value: Any) -> Any:
    if isinstance(value, str | Substitution | Absent):
        return text_of(context, value)
    if all(isinstance(item, bool | int | float) for item in value):
        return list(value)
    return text_of(context, value)


def _typed(value: Any, kind: Any) -> Any:
    if kind is None:
        return _of_yaml(value) if isinstance(value, str) else value
    if kind is str:
        return str(value)
    read = _of_yaml(value) if isinstance(value, str) else value
    inner = typing.get_args(kind)
    if inner or kind is list:
        if not isinstance(read, list):
            raise ValueError(f"'{value}' is not a list")
        return [_scalar(item, inner[0]) for item in read] if inner else read
    return _scalar(read, kind)


def _scalar(value: Any, kind: Any) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if kind is str and isinstance(value, bool | int | float):
        return str(value)
    if type(value) is not kind:
        raise ValueError(f"'{value}' is not a {getattr(kind, '__name__', kind)}")
    return value


def _of_file(context: Any, given: Any, found: Found) -> None:
    file = given if isinstance(given, ParameterFile) else ParameterFile(given)
    try:
        path = file.evaluate(context)
    except (AbsentError, RuntimeError) as error:
        found[1].append(("*", str(error)))
        return
    shown = os.path.basename(path)  # noqa: PTH119 - a name for a message
    try:
        text = read_text(path)
        context.reading.sources.append(path)
        if str(file.allow_substs).lower() in ("true", "1"):
            from tracerisk.pipeline.launch_files.texts import substitutions_of

            text = text_of(context, substitutions_of(text))
        found[0].extend(_kept(node_parameters(yaml_value(text))))
    except (ParameterTextError, AbsentError, RuntimeError) as error:
        found[1].append(("*", f"{shown}: {error}"))


def _kept(parameters: Sequence[LaunchParameter]) -> Iterator[LaunchParameter]:
    return (parameter for parameter in parameters if is_storable(parameter.value))
