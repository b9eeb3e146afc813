"""Substitutions in the texts of ROS 1 launch files: `$(find pkg)`, `$(arg name)`, `$(eval ...)`."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.expressions import evaluate
from tracerisk.pipeline.launch_files.parameter_text import ParameterTextError, yaml_value

_ONE = re.compile(r"\$\(([^()$]*)\)")
# What the host has sourced must not decide what a controller is given.
_OF_ROS = ("ROS_", "CATKIN_", "CMAKE_")
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


class RoslaunchError(ValueError):
    """Something in a launch file cannot be evaluated here."""


@dataclass(slots=True)
class Texts:
    """What substitutions are made of."""

    packages: Mapping[str, Path]
    """The folders of the workspace's packages, by package name."""
    folder: Path
    """The folder of the launch file, for `$(dirname)`."""
    arguments: dict[str, str] = field(default_factory=dict)
    """The value of each argument set so far."""

    def of(self, text: str) -> str:
        """Return a text with its substitutions made.

        Raises RoslaunchError at one that cannot be.
        """
        stripped = text.strip()
        if stripped.startswith("$(eval ") and stripped.endswith(")"):
            return _shown(self._eval(stripped[len("$(eval ") : -1]))
        return _ONE.sub(lambda found: self._made(found[1]), text)

    def holds(self, text: str) -> bool:
        """Return what the text of `if` or `unless` says.

        Raises RoslaunchError where it says neither true nor false.
        """
        value = self.of(text).strip().lower()
        if value not in _TRUTHS:
            raise RoslaunchError(f"'{text}' is neither true nor false")
        return _TRUTHS[value]

    def _made(self, inner: str) -> str:
        kind, *words = inner.split() or [""]
        if kind == "dirname":
            return str(self.folder)
        if kind == "optenv":
            if not words:
                raise RoslaunchError(f"$({inner}) names no variable")
            return self.env(words[0], " ".join(words[1:]))
        of_one_name: dict[str, Callable[[str], str]] = {
            "env": self.env,
            "find": self.find,
            "arg": self.arg,
            "anon": _anonymous,
        }
        if kind not in of_one_name:
            raise RoslaunchError(f"$({inner}) is not known")
        if len(words) != 1:
            raise RoslaunchError(f"$({inner}) needs one name")
        return of_one_name[kind](words[0])

    def find(self, name: str) -> str:
        """Return the folder of a package."""
        if name not in self.packages:
            raise RoslaunchError(f"package '{name}' is not here")
        return str(self.packages[name])

    def arg(self, name: str) -> str:
        """Return an argument of the launch file."""
        if name not in self.arguments:
            raise RoslaunchError(f"argument '{name}' has no value")
        return self.arguments[name]

    def env(self, name: str, default: str | None = None) -> str:
        """Return an environment variable."""
        value = default if name.startswith(_OF_ROS) else os.environ.get(name, default)
        if value is None:
            raise RoslaunchError(f"environment variable '{name}' is not set")
        return value

    def _eval(self, expression: str) -> Any:
        names: dict[str, Any] = {
            "arg": lambda name: _guessed(self.arg(name)),
            "find": self.find,
            "env": self.env,
            "optenv": lambda name, default="": self.env(name, default),
            "anon": _anonymous,
            "dirname": lambda: str(self.folder),
            **{name: _guessed(value) for name, value in self.arguments.items()},
        }
        try:
            return evaluate(expression, names)
        except ValueError as error:
            raise RoslaunchError(str(error)) from error


def _anonymous(name: str) -> str:
    # The same in each run: a trace must come out again.
    return f"{name}_anonymous"


def _guessed(text: str) -> Any:
    """Return what a text looks like: a number, a truth value, or itself."""
    for convert in (int, float):
        with contextlib.suppress(ValueError):
            return convert(text)
    plain = text.strip().lower()
    return _TRUTHS[plain] if plain in ("true", "false") else text


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def typed(text: str, kind: str) -> Any:
    """Return the value of a parameter that is written as a text.

    Raises RoslaunchError where it is none of its type.
    """
    readers: dict[str, Callable[[str], Any]] = {
        "auto": _guessed,
        "str": str,
        "string": str,
        "int": int,
        "double": float,
        **dict.fromkeys(("bool", "boolean"), lambda truth: _TRUTHS[truth.strip().lower()]),
        "yaml": yaml_value,
    }
    if kind not in readers:
        raise RoslaunchError(f"'{kind}' is not a type of a parameter")
    try:
        return readers[kind](text)
    except ParameterTextError as error:
        raise RoslaunchError(str(error)) from error
    except (KeyError, ValueError) as error:
        raise RoslaunchError(f"'{text}' is not a {kind}") from error
