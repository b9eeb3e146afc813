"""What a parameter is declared to be, and whether its descriptor lets it have a value."""

from __future__ import annotations

import math
import warnings
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, ParameterValue

from .parameter import Parameter, parameter_value_to_python
from .validate_parameter_name import validate_parameter_name

_NOT_SET = Parameter.Type.NOT_SET


def refusal(parameter: Parameter, descriptor: Any, *, is_new: bool) -> str:
    """Return why a descriptor refuses a value; empty where it does not."""
    if descriptor is None:
        return ""
    if descriptor.read_only and not is_new:
        return f"Trying to set a read-only parameter: {parameter.name}."
    if descriptor.dynamic_typing:
        pass
    elif parameter.type_ is _NOT_SET:
        # Declared by a type alone, or removed: only what is being declared may lack a value.
        return "" if is_new else "Static parameter cannot be undeclared"
    elif descriptor.type != parameter.type_.value:
        expected = Parameter.Type(descriptor.type)
        return f"Wrong parameter type, expected '{expected}' got '{parameter.type_}'"
    values = parameter.value if isinstance(parameter.value, list | tuple) else [parameter.value]
    if parameter.type_.name.startswith("INTEGER") and descriptor.integer_range:
        return _outside(parameter, values, descriptor.integer_range[0], is_whole=True)
    if parameter.type_.name.startswith("DOUBLE") and descriptor.floating_point_range:
        return _outside(parameter, values, descriptor.floating_point_range[0], is_whole=False)
    return ""


def _outside(parameter: Parameter, values: Any, span: Any, *, is_whole: bool) -> str:
    for value in values:
        if value in (span.from_value, span.to_value):
            continue
        if not span.from_value <= value <= span.to_value:
            dot = "." if is_whole else ""
            return (
                f"Parameter {parameter.name} out of range{dot} Min: {span.from_value}, "
                f"Max: {span.to_value}, value: {value}"
            )
        if span.step > 0:
            steps = (value - span.from_value) / span.step
            off = value - span.from_value - span.step * round(steps)
            if (is_whole and off) or not math.isclose(off, 0.0, abs_tol=1e-9):
                what = "a valid step" if is_whole else "close enough to a valid step"
                return (
                    f"The parameter value for {parameter.name} is not {what}. "
                    f"Min: {span.from_value}, max: {span.to_value}, value: {value}, "
                    f"step: {span.step}"
                )
    return ""


def declaration(namespace: str, index: int, entry: tuple[Any, ...]) -> tuple[str, Any, Any]:
    """Return name, value and descriptor of an entry of `Node.declare_parameters`.

    Raises TypeError and ValueError as it does.
    """
    if not 1 <= len(entry) <= 3:
        raise TypeError(
            f"Invalid parameter tuple length at index {index} in parameters list: "
            f"{entry}; expecting length between 1 and 3"
        )
    name = entry[0]
    if not isinstance(name, str):
        raise TypeError(f"First element {name} at index {index} in parameters list is not a str.")
    name = f"{namespace}.{name}" if namespace else name
    validate_parameter_name(name)
    second = entry[1] if len(entry) > 1 else None
    descriptor = entry[2] if len(entry) > 2 else ParameterDescriptor()
    if not isinstance(descriptor, ParameterDescriptor):
        raise TypeError(
            f"Third element {descriptor} at index {index} in parameters list "
            "is not a ParameterDescriptor."
        )
    if len(entry) == 1:
        warnings.warn(
            f"when declaring parameter named '{name}', declaring a parameter only providing "
            "its name is deprecated; give a default value, a type, or a descriptor with "
            "`dynamic_typing=True`",
            stacklevel=4,
        )
        descriptor.dynamic_typing = True
    if isinstance(second, Parameter.Type):
        if second is _NOT_SET:
            raise ValueError(
                f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET"
            )
        if descriptor.dynamic_typing:
            raise ValueError(
                f"When declaring parameter {{{name}}} passing a descriptor with "
                "`dynamic_typing=True` is not allowed when the parameter type is provided"
            )
        descriptor.type = second.value
        return name, None, descriptor
    if isinstance(second, ParameterValue):
        second = parameter_value_to_python(second)
    if not descriptor.dynamic_typing:
        descriptor.type = Parameter.Type.from_parameter_value(second).value
        if descriptor.type == _NOT_SET.value:
            raise ValueError(
                "Cannot declare a statically typed parameter with default value "
                "of type PARAMETER_NOT_SET"
            )
    return name, second, descriptor
