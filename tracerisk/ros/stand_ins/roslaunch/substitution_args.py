"""Substitutions as in launch files: `$(find pkg)`, `$(arg name)`, `$(env NAME)`."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from typing import Any

from rospkg import RosPack

__all__ = ["ArgException", "SubstitutionException", "resolve_args"]

_ONE = re.compile(r"\$\(([^()]+)\)")


class SubstitutionException(Exception):
    """A substitution is malformed, not known, or has no value."""


class ArgException(SubstitutionException):
    """An argument has no value."""


def resolve_args(
    arg_str: str | None, context: dict[str, Any] | None = None, resolve_anon: bool = True
) -> str | None:
    """Return a text with its substitutions made; `context["arg"]` has the values of arguments.

    Raises:
        SubstitutionException: one is malformed or not known, or a variable is not set.
        ArgException: an argument has no value.
        ResourceNotFound: a package is not there.
    """
    if not arg_str:
        return arg_str
    if arg_str.startswith("$(eval "):
        raise SubstitutionException(f"$(eval ...) is not served [{arg_str}]")
    given: dict[str, Any] = {} if context is None else context
    makers: dict[str, Callable[[list[str]], str]] = {
        "env": lambda words: _variable(words[0]),
        "optenv": lambda words: os.environ.get(words[0], " ".join(words[1:])),
        "anon": lambda words: _anonymous(words[0], given),
        "arg": lambda words: _argument(words[0], given),
        "find": lambda words: RosPack().get_path(words[0]),
    }

    def made(found: re.Match[str]) -> str:
        kind, *words = found[1].split() or [""]
        if kind not in makers:
            known = ", ".join(sorted(makers))
            raise SubstitutionException(
                f"Unknown substitution command [{found[1]}]. Valid commands are {known}"
            )
        if not words or (len(words) > 1 and kind != "optenv"):
            raise SubstitutionException(f"$({kind} ...) takes one name [{found[1]}]")
        return found[0] if kind == "anon" and not resolve_anon else makers[kind](words)

    return _ONE.sub(made, arg_str)


def _variable(name: str) -> str:
    if name not in os.environ:
        raise SubstitutionException(f"environment variable '{name}' is not set")
    return os.environ[name]


def _argument(name: str, context: dict[str, Any]) -> str:
    values: dict[str, str] = context.setdefault("arg", {})
    if name not in values:
        raise ArgException(name)
    return values[name]


def _anonymous(name: str, context: dict[str, Any]) -> str:
    # The same in each run: a trace must come out again.
    names: dict[str, str] = context.setdefault("anon", {})
    return names.setdefault(name, f"{name}_anonymous")
