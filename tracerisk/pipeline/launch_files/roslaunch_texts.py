"""Substitutions in the texts of ROS 1 launch files: `$(find pkg)`, `$(arg name)`, `$(eval ...)`."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracerisk.pipeline.launch_files.expressions import evaluate

_ONE = re.compile(r"\$\(([^()$]*)\)")
# What the host has sourced must not decide what a controller is given.
_OF_ROS = ("ROS_", "CATKIN_", "CMAKE_")
_TRUE, _FALSE = frozenset({"true", "1"}), frozenset({"false", "0"})


class RoslaunchError(ValueError):
    """Something in a launch file cannot be evaluated here."""


@dataclass(slots=True)
class Texts:
    """What substitutions are made of: the packages, the file's folder, its arguments."""

    packages: Mapping[str, Path]
    folder: Path
    arguments: dict[str, str] = field(default_factory=dict)

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
        if value in _TRUE:
            return True
        if value in _FALSE:
            return False
        raise RoslaunchError(f"'{text}' is neither true nor false")

    def _made(self, inner: str) -> str:
        words = inner.split()
        if not words or words[0] not in _KNOWN:
            raise RoslaunchError(f"$({inner}) is not known")
        return _KNOWN[words[0]](self, words[1:], inner)

    def find(self, name: str) -> str:
        """Return the folder of a package: its source, for nothing is installed."""
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
            "arg": lambda name: _converted(self.arg(name)),
            "find": self.find,
            "env": self.env,
            "optenv": lambda name, default="": self.env(name, default),
            "anon": _anonymous,
            "dirname": lambda: str(self.folder),
            **{name: _converted(value) for name, value in self.arguments.items()},
        }
        try:
            return evaluate(expression, names)
        except ValueError as error:
            raise RoslaunchError(str(error)) from error


def _of_env(texts: Texts, words: list[str], inner: str) -> str:
    return texts.env(_only(words, inner))


def _of_optenv(texts: Texts, words: list[str], inner: str) -> str:
    if not words:
        raise RoslaunchError(f"$({inner}) names no variable")
    return texts.env(words[0], " ".join(words[1:]))


def _of_find(texts: Texts, words: list[str], inner: str) -> str:
    return texts.find(_only(words, inner))


def _of_arg(texts: Texts, words: list[str], inner: str) -> str:
    return texts.arg(_only(words, inner))


def _of_anon(_texts: Texts, words: list[str], inner: str) -> str:
    return _anonymous(_only(words, inner))


def _of_dirname(texts: Texts, _words: list[str], _inner: str) -> str:
    return str(texts.folder)


_KNOWN: dict[str, Callable[[Texts, list[str], str], str]] = {
    "env": _of_env,
    "optenv": _of_optenv,
    "find": _of_find,
    "arg": _of_arg,
    "anon": _of_anon,
    "dirname": _of_dirname,
}


def _only(words: list[str], inner: str) -> str:
    if len(words) != 1:
        raise RoslaunchError(f"$({inner}) needs one name")
    return words[0]


def _anonymous(name: str) -> str:
    # The same in each run: a trace must come out again.
    return f"{name}_anonymous"


def _converted(text: str) -> Any:
    """Return an argument as an expression sees it: a number or a truth value where it looks so."""
    value = typed(text, "auto")
    return text if isinstance(value, list | dict) else value


def _shown(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def typed(text: str, kind: str) -> Any:
    """Return the value of a parameter that is written as a text.

    Raises RoslaunchError where it is none of its type.
    """
    from tracerisk.pipeline.launch_files.parameter_text import ParameterTextError, yaml_value

    plain = text.strip()
    try:
        if kind == "auto":
            for convert in (int, float):
                try:
                    return convert(plain)
                except ValueError:
                    continue
            return plain.lower() == "true" if plain.lower() in ("true", "false") else text
        if kind in ("str", "string"):
            return text
        if kind == "int":
            return int(plain)
        if kind == "double":
            return float(plain)
        if kind in ("bool", "boolean"):
            if plain.lower() not in _TRUE | _FALSE:
                raise RoslaunchError(f"'{text}' is not a bool")
            return plain.lower() in _TRUE
        if kind == "yaml":
            return yaml_value(text)
    except ParameterTextError as error:
        raise RoslaunchError(str(error)) from error
    except ValueError as error:
        raise RoslaunchError(f"'{text}' is not a {kind}") from error
    raise RoslaunchError(f"'{kind}' is not a type of a parameter")
