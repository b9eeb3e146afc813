"""Substitutions in the texts of ROS 2 launch files of XML and YAML: `$(var speed)`."""

from __future__ import annotations

import shlex
from collections.abc import Callable

from tracerisk.pipeline.launch_files.stand_ins.launch import substitutions as subs
from tracerisk.pipeline.launch_files.stand_ins.launch.substitution import Substitution
from tracerisk.pipeline.launch_files.stand_ins.launch_ros import substitutions as ros

_Argument = list[Substitution]


class LaunchTextError(ValueError):
    """A text holds a substitution that is malformed or not known."""


def substitutions_of(text: str) -> list[Substitution]:
    """Return the substitutions whose joined texts a text stands for.

    Raises LaunchTextError at one that is malformed or not known.
    """
    substitutions, _ = _read(text, 0, within=False)
    return substitutions


def _read(text: str, at: int, *, within: bool) -> tuple[list[Substitution], int]:
    """Read to the end, or to the parenthesis that closes the substitution around."""
    substitutions: list[Substitution] = []
    plain = ""
    while at < len(text):
        if text.startswith("\\$", at):
            plain, at = plain + "$", at + 2
        elif text.startswith("$(", at):
            if plain:
                substitutions.append(subs.TextSubstitution(text=plain))
                plain = ""
            made, at = _substitution(text, at + 2)
            substitutions.append(made)
        elif within and text[at] == ")":
            break
        else:
            plain, at = plain + text[at], at + 1
    if plain:
        substitutions.append(subs.TextSubstitution(text=plain))
    return substitutions, at


def _substitution(text: str, at: int) -> tuple[Substitution, int]:
    end = at
    while end < len(text) and not text[end].isspace() and text[end] not in "()":
        end += 1
    name = text[at:end]
    arguments, at = _arguments(text, end, is_one=name in ("eval", "command"))
    if name not in _KNOWN:
        raise LaunchTextError(f"$({name} ...) is not known")
    least, most, make = _KNOWN[name]
    if not least <= len(arguments) <= most:
        raise LaunchTextError(f"$({name} ...) has {len(arguments)} arguments")
    return make(*arguments), at


def _arguments(text: str, at: int, *, is_one: bool) -> tuple[list[_Argument], int]:
    """Read the arguments up to the closing parenthesis; quotes keep spaces together."""
    arguments: list[_Argument] = []
    parts: _Argument = []
    plain, has_any, quote, depth = "", False, "", 0

    def flush() -> None:
        nonlocal plain
        if plain:
            parts.append(subs.TextSubstitution(text=plain))
            plain = ""

    while True:
        if at >= len(text):
            raise LaunchTextError(f"a substitution of '{text}' has no closing parenthesis")
        char = text[at]
        if text.startswith("$(", at):
            flush()
            made, at = _substitution(text, at + 2)
            parts.append(made)
            has_any = True
            continue
        at += 1
        if not quote and char == ")" and depth == 0:
            break
        if is_one:
            depth += (char == "(") - (char == ")")
            # Its quotes belong to the expression, unless they are around all of it.
            if plain or has_any or not char.isspace():
                plain, has_any = plain + char, True
        elif quote:
            if char == quote:
                quote = ""
            else:
                plain += char
        elif char in "\"'":
            quote, has_any = char, True
        elif char.isspace():
            flush()
            if has_any:
                arguments.append(parts)
                parts, has_any = [], False
        else:
            plain, has_any = plain + char, True
    flush()
    if has_any:
        arguments.append(parts)
    if is_one and arguments:
        arguments = [_unquoted(arguments[0])]
    return arguments, at


def _unquoted(argument: _Argument) -> _Argument:
    """Return an expression without the quotes that are around all of it."""
    first, last = argument[0], argument[-1]
    if not isinstance(first, subs.TextSubstitution) or not isinstance(last, subs.TextSubstitution):
        return argument
    quote, end = first.text[:1], last.text.rstrip()
    inner = "".join(p.text for p in argument if isinstance(p, subs.TextSubstitution)).strip()
    if quote not in ('"', "'") or not end.endswith(quote) or inner.count(quote) != 2:
        return argument
    if first is last:
        return [subs.TextSubstitution(text=end[1:-1])]
    return [
        subs.TextSubstitution(text=first.text[1:]),
        *argument[1:-1],
        subs.TextSubstitution(text=end[:-1]),
    ]


_KNOWN: dict[str, tuple[int, int, Callable[..., Substitution]]] = {
    "var": (1, 2, lambda name, default=None: subs.LaunchConfiguration(name, default=default)),
    "env": (
        1,
        2,
        lambda name, default=None: subs.EnvironmentVariable(name, default_value=default),
    ),
    "optenv": (
        1,
        2,
        lambda name, default="": subs.EnvironmentVariable(name, default_value=default),
    ),
    "find-pkg-share": (1, 1, ros.FindPackageShare),
    "find-pkg-prefix": (1, 1, ros.FindPackagePrefix),
    "exec-in-pkg": (2, 2, ros.ExecutableInPackage),
    "find-exec": (1, 1, lambda name: subs.FindExecutable(name=name)),
    "dirname": (0, 0, subs.ThisLaunchFileDir),
    "filename": (0, 0, subs.ThisLaunchFile),
    "anon": (1, 1, subs.AnonName),
    "eval": (1, 1, subs.PythonExpression),
    "command": (1, 2, lambda command, *_: subs.Command(command)),
    "file-content": (1, 1, subs.FileContent),
    "param": (1, 2, lambda name, default=None: ros.Parameter(name, default=default)),
    "not": (1, 1, subs.NotSubstitution),
    "and": (2, 2, subs.AndSubstitution),
    "or": (2, 2, subs.OrSubstitution),
    "any": (0, 100, subs.AnySubstitution),
    "all": (0, 100, subs.AllSubstitution),
    "equals": (2, 2, subs.EqualsSubstitution),
    "not-equals": (2, 2, subs.NotEqualsSubstitution),
    "if": (1, 3, subs.IfElseSubstitution),
}


def words_of(text: str) -> list[list[Substitution]]:
    """Return the words of a command line, each as its substitutions."""
    words: list[str] = []
    current, depth = "", 0
    for position, char in enumerate(text):
        if text.startswith("$(", position):
            depth += 1
        elif char == ")" and depth:
            depth -= 1
        if char.isspace() and not depth:
            words.append(current)
            current = ""
        else:
            current += char
    words.append(current)
    return [substitutions_of(_plain(word)) for word in words if word]


def _plain(word: str) -> str:
    """Return a word without the quotes of a shell, if it has no substitution in it."""
    if "$(" in word:
        return word
    try:
        return " ".join(shlex.split(word))
    except ValueError:
        return word
