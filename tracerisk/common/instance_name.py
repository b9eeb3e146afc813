"""The name of a state of the chain that is one instance of several: `Pick (tray)`.

Where a function is a method of a state or behaviour that exists several times, what each instance
does is a state of its own, with a block of its own in that method. Its name is the class, or the
method where several of its methods command, and the label of the instance.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TypeVar

from tracerisk.common.function_ref import QualifiedName

_INSTANCE = r"(?P<of>\S+) \((?P<label>[^\s()]+(?: [^\s()]+)*)\)"
# What separates names and values in blocks and on the command line.
_SEPARATORS = r"[\s!{}(),;:=/@#]+"
_LONGEST_LABEL = 40

Name = TypeVar("Name", bound=str)


def plain_label(text: str) -> str:
    """Return a label as a block can hold it, without what separates names there; may be empty."""
    import unicodedata  # for instances alone

    text = unicodedata.normalize("NFKC", text)
    words = re.sub(_SEPARATORS, " ", "".join(name if name.isprintable() else " " for name in text))
    return " ".join(words.split())[:_LONGEST_LABEL].strip()


def instance_name(function: str, label: str, *, is_only_method: bool) -> QualifiedName:
    """Return the name of what a function does as one instance.

    `is_only_method`: no other method of its class has blocks.
    """
    of = function.rpartition(".")[0] if is_only_method else ""
    return QualifiedName(f"{of or function} ({label})")


def _parts_of(name: str) -> re.Match[str] | None:
    """Return what a name says of its instance; `None` for that of a function."""
    return re.fullmatch(_INSTANCE, name) if name.endswith(")") else None


def is_name_at(name: str, function: str) -> bool:
    """Return whether a block of this name may stand in a function: its own, or an instance's."""
    parts = _parts_of(name)
    if parts is None:
        return name == function
    return parts["of"] in (function, function.rpartition(".")[0])


def name_at(name: str, function: Name) -> Name | QualifiedName:
    """Return what a block is to be called that stands in a function under a name not its own."""
    parts = _parts_of(name)
    if parts is None:
        return function
    is_method = parts["of"].rpartition(".")[2] == function.rpartition(".")[2]
    return instance_name(function, parts["label"], is_only_method=not is_method)


def places(name: str, functions: Iterable[tuple[Name, int]]) -> list[int]:
    """Return the lines of the functions, given as pairs, in which a block of the name stands."""
    return [line for function, line in functions if is_name_at(name, function)]
