"""The generator by its older name."""

from __future__ import annotations

from .parameter_generator_catkin import ParameterGenerator, bool_t, double_t, int_t, str_t

__all__ = ["ParameterGenerator", "bool_t", "double_t", "int_t", "str_t"]
