"""Whether a descriptor lets a parameter have a value."""

from __future__ import annotations

import math
from typing import Any

from .parameter import Parameter

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
