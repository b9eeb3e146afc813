"""Parameters of nodes."""

from __future__ import annotations

import array
from enum import Enum
from operator import attrgetter
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType, ParameterValue

from ._arguments import flat_parameters, read_yaml

PARAMETER_SEPARATOR_STRING = "."

_SCALARS: tuple[tuple[type, str], ...] = (
    (bool, "BOOL"),
    (int, "INTEGER"),
    (float, "DOUBLE"),
    (str, "STRING"),
)
_ELEMENTS: tuple[tuple[type, str], ...] = (
    (bytes, "BYTE_ARRAY"),
    *((kind, f"{name}_ARRAY") for kind, name in _SCALARS),
)


class _Type(Enum):
    """The types that a parameter can have."""

    NOT_SET = ParameterType.PARAMETER_NOT_SET
    BOOL = ParameterType.PARAMETER_BOOL
    INTEGER = ParameterType.PARAMETER_INTEGER
    DOUBLE = ParameterType.PARAMETER_DOUBLE
    STRING = ParameterType.PARAMETER_STRING
    BYTE_ARRAY = ParameterType.PARAMETER_BYTE_ARRAY
    BOOL_ARRAY = ParameterType.PARAMETER_BOOL_ARRAY
    INTEGER_ARRAY = ParameterType.PARAMETER_INTEGER_ARRAY
    DOUBLE_ARRAY = ParameterType.PARAMETER_DOUBLE_ARRAY
    STRING_ARRAY = ParameterType.PARAMETER_STRING_ARRAY

    @classmethod
    def from_parameter_value(cls, parameter_value: Any) -> _Type:
        """Return the type of a value.

        Raises:
            TypeError: no parameter can have it.
        """
        if parameter_value is None:
            return cls.NOT_SET
        for kind, name in _SCALARS:
            if isinstance(parameter_value, kind):
                return cls[name]
        if not isinstance(parameter_value, list | tuple | array.array):
            raise TypeError(f"The given value is not one of the allowed types '{parameter_value}'.")
        for kind, name in _ELEMENTS:
            if all(isinstance(item, kind) for item in parameter_value):
                return cls[name]
        raise TypeError(
            f"The given value is not a list of one of the allowed types '{parameter_value}'."
        )

    @property
    def _field(self) -> str:
        """The field of rcl_interfaces/ParameterValue that holds such a value."""
        return f"{self.name.lower()}_value"

    def check(self, parameter_value: Any) -> bool:
        """Return whether a value is of the type."""
        if self is _Type.NOT_SET:
            return parameter_value is None
        for kind, name in _SCALARS:
            if self.name == name:
                return isinstance(parameter_value, kind)
        element = next(kind for kind, name in _ELEMENTS if self.name == name)
        return isinstance(parameter_value, list | tuple | array.array) and all(
            isinstance(item, element) for item in parameter_value
        )


_Type.__name__, _Type.__qualname__ = "Type", "Parameter.Type"


class Parameter:
    """A name, a type and a value.

    Raises:
        TypeError: `type_` is none, or the value of no type that a parameter can have.
        ValueError: type and value do not agree.
    """

    Type = _Type

    def __init__(self, name: str, type_: _Type | None = None, value: Any = None) -> None:
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        if not isinstance(type_, Parameter.Type):
            raise TypeError(f"type must be an instance of '{Parameter.Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._type_ = type_
        self._name = name
        self._value = value

    @classmethod
    def from_parameter_msg(cls, param_msg: Any) -> Parameter:
        """Return the parameter of a rcl_interfaces/Parameter."""
        type_ = Parameter.Type(param_msg.value.type)
        value = parameter_value_to_python(param_msg.value)
        return cls(param_msg.name, type_, value)

    name = property(attrgetter("_name"), doc="The name.")

    type_ = property(attrgetter("_type_"), doc="The type.")

    value = property(attrgetter("_value"), doc="The value; None of a parameter that is not set.")

    def get_parameter_value(self) -> Any:
        """Return the value as a rcl_interfaces/ParameterValue."""
        made = ParameterValue(type=self.type_.value)
        if self.type_ is not Parameter.Type.NOT_SET:
            setattr(made, self.type_._field, self.value)
        return made

    def to_parameter_msg(self) -> Any:
        """Return the parameter as a rcl_interfaces/Parameter."""
        return ParameterMsg(name=self.name, value=self.get_parameter_value())

    def __repr__(self) -> str:
        return f"Parameter(name={self.name!r}, type_={self.type_}, value={self.value!r})"


def get_parameter_value(string_value: str) -> Any:
    """Return what a YAML text stands for as a rcl_interfaces/ParameterValue."""
    value = read_yaml(string_value)
    try:
        type_ = Parameter.Type.from_parameter_value(value)
    except TypeError:
        type_ = Parameter.Type.NOT_SET
    if type_ is Parameter.Type.NOT_SET:
        type_, value = Parameter.Type.STRING, string_value
    return Parameter("value", type_, value).get_parameter_value()


def parameter_dict_from_yaml_file(
    parameter_file: str,
    use_wildcard: bool = False,
    target_nodes: list[str] | None = None,
    namespace: str = "",
) -> dict[str, Any]:
    """Return the parameters of a YAML file as rcl_interfaces/Parameter messages, by their names.

    Those of `target_nodes`, or of all nodes; those of `/**` only with `use_wildcard`, and before
    the others.

    Raises:
        RuntimeError: a target node is not in the file, no node is, or the file is none of
            parameters.
    """
    content = read_yaml(Path(parameter_file).read_text(encoding="utf-8"))
    if target_nodes:
        for name in target_nodes:
            if name not in content:
                raise RuntimeError(
                    f"Param file does not contain parameters for {name},"
                    f"only for nodes: {list(content)} "
                )
    chosen = ["/**"] if use_wildcard and "/**" in content else []
    chosen += target_nodes or [name for name in content if name != "/**"]
    if not chosen:
        raise RuntimeError("Param file does not contain selected parameters")
    tree: dict[str, Any] = {}
    for name in chosen:
        section = content[name]
        if not isinstance(section, dict) or "ros__parameters" not in section:
            raise RuntimeError(f"YAML file is not a valid ROS parameter file for node {name}")
        tree |= section["ros__parameters"]
    return {
        name: ParameterMsg(name=name, value=get_parameter_value(str(value)))
        for name, value in flat_parameters(namespace, tree)
    }


def parameter_value_to_python(parameter_value: Any) -> Any:
    """Return the value of a rcl_interfaces/ParameterValue; None where it is not set.

    Raises:
        RuntimeError: its type is none.
    """
    try:
        type_ = Parameter.Type(parameter_value.type)
    except ValueError as error:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}") from error
    if type_ is Parameter.Type.NOT_SET:
        return None
    value = getattr(parameter_value, type_._field)
    return list(value) if type_.name.endswith("ARRAY") else value
