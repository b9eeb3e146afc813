"""Walk through a ROS 2 launch file of any kind with the stand-ins of `launch`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from tracerisk.pipeline.launch_files.parameter_text import read_text
from tracerisk.pipeline.launch_files.placeholders import AbsentError
from tracerisk.pipeline.launch_files.robot_sources import source_of_file
from tracerisk.pipeline.launch_files.stand_ins.launch.actions import IncludeLaunchDescription
from tracerisk.pipeline.launch_files.stand_ins.launch.launch_context import LaunchContext, Reading
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of
from tracerisk.pipeline.launch_files.xml import description_of_xml, description_of_yaml

Described = tuple[str, Mapping[str, Any]]
"""A file of a robot by its path, and the arguments for xacro as the launch file has them."""

_FUNCTIONS = ("generate_launch_description", "generate_test_description")


def visit(
    path: Path,
    packages: Mapping[str, Path],
    described: Sequence[Described],
    arguments: Sequence[tuple[str, str]] = (),
) -> Reading:
    """Return what a launch file starts with some arguments, and the defaults of the others.

    `described` are the files of robots that are met on the way, and what xacro is given for them,
    to which a launch configuration may belong.
    """
    context = LaunchContext()
    context.packages = packages
    context.walk(IncludeLaunchDescription(str(path), launch_arguments=list(arguments)))
    context.fire_handlers()
    context.reading.robots += [
        source_of_file(
            file, {name: _known(argument, context) for name, argument in arguments.items()}
        )
        for file, arguments in described
    ]
    return context.reading


def _known(value: Any, context: LaunchContext) -> Any:
    """Return the text of a substitution, `None` for one that has none; other values as they are."""
    if not isinstance(value, Substitution | list | tuple):
        return value
    try:
        return text_of(context, value)
    # Whatever a substitution of anybody raises, its value is not known.
    except Exception:  # noqa: BLE001
        return None


def describe(path: Path, context: LaunchContext) -> Any:
    """Return the description that a launch file holds.

    Raises whatever a launch file in Python raises, and an error where it cannot be read.
    """
    if not path.is_file():
        raise AbsentError(f"launch file '{path.name}' is not here")
    text = read_text(path)
    context.reading.sources.append(path)
    if path.suffix == ".py":
        return _of_python(path, text)
    if path.suffix in (".yaml", ".yml"):
        return description_of_yaml(text)
    return description_of_xml(text, path.name)


def _of_python(path: Path, text: str) -> Any:
    # A module of its own, which dataclasses and the like look up by its name.
    name = f"launch_file_{len(sys.modules)}"
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    exec(compile(text, str(path), "exec", dont_inherit=True), module.__dict__)
    for word in _FUNCTIONS:
        function = getattr(module, word, None)
        if function is not None:
            made = function()
            # A test's description may come with a dictionary of what it names.
            return made[0] if isinstance(made, tuple) else made
    raise AttributeError(f"{path.name} has no generate_launch_description()")


LaunchContext.read_file = staticmethod(describe)
