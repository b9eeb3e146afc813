"""`launch.substitutions`."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.expressions import evaluate
from tracerisk.pipeline.launch_files.placeholders import AbsentError
from tracerisk.pipeline.launch_files.robot_sources import RobotSource, source_of_command
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.pipeline.launch_files.stand_ins.launch.utilities import text_of


class SubstitutionFailure(RuntimeError):
    """A substitution has no text."""


class TextSubstitution(Substitution):
    """A text."""

    def __init__(self, *, text: str) -> None:
        if not isinstance(text, str):
            raise TypeError(f"TextSubstitution expected Text object got '{type(text)}' instead.")
        self.text = text

    def perform(self, context: Any) -> str:
        """Return the text."""
        return self.text


class LaunchConfiguration(Substitution):
    """The value of a launch configuration: an argument of the launch file, mostly."""

    def __init__(self, variable_name: Any, *, default: Any = None) -> None:
        self.variable_name = variable_name
        self.default = default

    def perform(self, context: Any) -> str:
        """Return the value, else the default."""
        name = text_of(context, self.variable_name)
        if name in context.launch_configurations:
            return str(context.launch_configurations[name])
        if self.default is None:
            raise SubstitutionFailure(f"launch configuration '{name}' does not exist")
        default = self.default
        is_plain = isinstance(default, bool | int | float)
        return str(default) if is_plain else text_of(context, default)


class EnvironmentVariable(Substitution):
    """The value of an environment variable."""

    def __init__(self, name: Any, *, default_value: Any = None) -> None:
        self.name = name
        self.default_value = default_value

    def perform(self, context: Any) -> str:
        """Return the value, else the default."""
        name = text_of(context, self.name)
        if name in context.environment:
            return str(context.environment[name])
        if self.default_value is None:
            raise SubstitutionFailure(f"environment variable '{name}' does not exist")
        return text_of(context, self.default_value)


class PathSubstitution(Substitution):
    """Parts of a path, joined by `/`."""

    def __init__(self, path: Any) -> None:
        self._parts = [path]

    def __truediv__(self, part: Any) -> PathSubstitution:
        joined = PathSubstitution("")
        joined._parts = [*self._parts, part]
        return joined

    def perform(self, context: Any) -> str:
        """Return the path."""
        return str(Path(*(text_of(context, part) for part in self._parts)))


class PathJoinSubstitution(PathSubstitution):
    """Parts of a path, joined."""

    def __init__(self, substitutions: Iterable[Any]) -> None:
        super().__init__("")
        self._parts = list(substitutions)


class StringJoinSubstitution(Substitution):
    """Texts, joined by a delimiter."""

    def __init__(self, substitutions: Iterable[Any], delimiter: Any = "") -> None:
        self._parts = list(substitutions)
        self._delimiter = delimiter

    def perform(self, context: Any) -> str:
        """Return the joined text."""
        return text_of(context, self._delimiter).join(text_of(context, p) for p in self._parts)


class FindExecutable(Substitution):
    """A program of the machine: known by its name alone, for none is started."""

    def __init__(self, *, name: Any) -> None:
        self.name = name

    def perform(self, context: Any) -> str:
        """Return the program's name."""
        return text_of(context, self.name)


class Command(Substitution):
    """The output of a program, which is not run."""

    def __init__(self, command: Any, *, on_stderr: Any = "fail") -> None:
        self.command = command

    def perform(self, context: Any) -> str:
        """Raise AbsentError: no program is run."""
        try:
            command = text_of(context, self.command)
        except AbsentError as error:
            context.reading.robots.append(RobotSource("", problem=str(error)))
            raise
        made = source_of_command(command, Path.cwd())
        context.reading.robots += [] if made is None else [made]
        words = command.split()
        program = os.path.basename(words[0]) if words else "it"  # noqa: PTH119 - may be no path
        raise AbsentError(f"the output of {program} is not here")


class PythonExpression(Substitution):
    """The value of a small Python expression."""

    def __init__(self, expression: Any, python_modules: Any = ("math",)) -> None:
        self.expression = expression
        self.python_modules = python_modules

    def describe(self) -> str:
        """Return the expression and the modules that it may use."""
        modules = self.python_modules
        reported = [modules] if isinstance(modules, str) else [str(module) for module in modules]
        parts = [self.expression] if isinstance(self.expression, str) else self.expression
        text = "".join(part if isinstance(part, str) else part.describe() for part in parts)
        return f"PythonExpr('{text}', {reported})"

    def perform(self, context: Any) -> str:
        """Return the value as text."""
        text = text_of(context, self.expression)
        try:
            return str(evaluate(text, {"math": math}))
        except ValueError as error:
            raise SubstitutionFailure(str(error)) from error


class ThisLaunchFile(Substitution):
    """The path of the launch file."""

    def perform(self, context: Any) -> str:
        """Return the path."""
        return _of_file(context, "current_launch_file_path")


class ThisLaunchFileDir(Substitution):
    """The folder of the launch file."""

    def perform(self, context: Any) -> str:
        """Return the folder."""
        return _of_file(context, "current_launch_file_directory")


def _of_file(context: Any, name: str) -> str:
    values = context.get_locals_as_dict()
    if name not in values:
        raise SubstitutionFailure("this is not within a launch file: its path is not known")
    return str(values[name])


class LocalSubstitution(Substitution):
    """A local value of the context."""

    def __init__(self, expression: str, description: str | None = None) -> None:
        self.expression = expression

    def perform(self, context: Any) -> str:
        """Return the value as text."""
        values = context.get_locals_as_dict()
        if self.expression not in values:
            raise SubstitutionFailure(f"nothing local is called '{self.expression}'")
        return str(values[self.expression])


class AnonName(Substitution):
    """A name that nothing else has: always the same, so that a run can be repeated."""

    def __init__(self, name: Any) -> None:
        self.name = name

    def perform(self, context: Any) -> str:
        """Return the name."""
        return f"{text_of(context, self.name)}_anonymous"


class FileContent(Substitution):
    """What a file holds."""

    def __init__(self, path: Any) -> None:
        self.path = path

    def perform(self, context: Any) -> str:
        """Return the text of the file."""
        path = Path(text_of(context, self.path))
        context.reading.sources.append(path)
        if not path.is_file():
            raise SubstitutionFailure(f"File not found: {path}")
        return path.read_text(encoding="utf-8")


class LaunchLogDir(Substitution):
    """The folder of log files, of which none is written."""

    def perform(self, context: Any) -> str:
        """Raise AbsentError."""
        raise AbsentError("the folder of log files is not here")


_AS_BOOL = {"true": True, "1": True, "false": False, "0": False}
_YAML_BOOL = {**_AS_BOOL, "yes": True, "on": True, "no": False, "off": False}


def _plain(context: Any, value: Any) -> str:
    if value is None:
        return ""
    return str(value) if isinstance(value, bool | int | float) else text_of(context, value)


def _truth(context: Any, value: Any) -> bool:
    """Return what a text says, in YAML's words.

    Raises:
        SubstitutionFailure: it says neither true nor false.
    """
    text = _plain(context, value).strip().lower()
    if text not in _YAML_BOOL:
        raise SubstitutionFailure(f"'{text}' is no truth value; use one of {sorted(_YAML_BOOL)}")
    return _YAML_BOOL[text]


class EqualsSubstitution(Substitution):
    """`true` where two texts are equal, as numbers or truth values too."""

    def __init__(self, left: Any, right: Any) -> None:
        self._sides = (left, right)

    def _equal(self, context: Any) -> bool:
        left, right = (_plain(context, side) for side in self._sides)
        if left.lower() in _AS_BOOL and right.lower() in _AS_BOOL:
            return _AS_BOOL[left.lower()] == _AS_BOOL[right.lower()]
        try:
            return math.isclose(float(left), float(right))
        except ValueError:
            return left == right

    def perform(self, context: Any) -> str:
        """Return `true` or `false`."""
        return str(self._equal(context)).lower()


class NotEqualsSubstitution(EqualsSubstitution):
    """`true` where two texts differ."""

    def perform(self, context: Any) -> str:
        """Return `true` or `false`."""
        return str(not self._equal(context)).lower()


class NotSubstitution(Substitution):
    """`true` where a text says false."""

    def __init__(self, value: Any) -> None:
        self._value = value

    def perform(self, context: Any) -> str:
        """Return `true` or `false`."""
        return str(not _truth(context, self._value)).lower()


class AllSubstitution(Substitution):
    """`true` where all texts say true."""

    def __init__(self, *args: Any) -> None:
        self._values = args

    def perform(self, context: Any) -> str:
        """Return `true` or `false`."""
        said = [_truth(context, value) for value in self._values]
        return str(all(said)).lower()


class AnySubstitution(AllSubstitution):
    """`true` where a text says true."""

    def perform(self, context: Any) -> str:
        """Return `true` or `false`."""
        said = [_truth(context, value) for value in self._values]
        return str(any(said)).lower()


class AndSubstitution(AllSubstitution):
    """`true` where both texts say true."""

    def __init__(self, left: Any, right: Any) -> None:
        super().__init__(left, right)


class OrSubstitution(AnySubstitution):
    """`true` where one of two texts says true."""

    def __init__(self, left: Any, right: Any) -> None:
        super().__init__(left, right)


class IfElseSubstitution(Substitution):
    """One of two texts."""

    def __init__(self, condition: Any, if_value: Any = "", else_value: Any = "") -> None:
        if isinstance(if_value, str) and isinstance(else_value, str) and not if_value + else_value:
            raise RuntimeError("One of if_value and else_value must be specified")
        self._condition = condition
        self._values = (else_value, if_value)

    def perform(self, context: Any) -> str:
        """Return the text that the condition chooses."""
        return text_of(context, self._values[_truth(context, self._condition)])
