"""Stand-in for launch_param_builder: parameters from the files of a package."""

from .parameter_builder import (
    ParameterBuilder,
    ParameterBuilderFileNotFoundError,
    load_file,
    load_xacro,
    load_yaml,
    raise_if_file_not_found,
)

__all__ = [
    "ParameterBuilder",
    "ParameterBuilderFileNotFoundError",
    "load_file",
    "load_xacro",
    "load_yaml",
    "raise_if_file_not_found",
]
