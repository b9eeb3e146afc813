"""Which known anomalies of docs/safety.md a figure's sources may meet, by their lines."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.surroundings import places


class Anomaly(NamedTuple):
    """An error or omission that is known and not yet mended."""

    number: str
    """Its number in the safety manual, such as `K1`."""
    concerns: str
    """Whom it concerns: you, if..."""
    is_met: Callable[[ast.AST], bool]
    """Whether a node of a source's syntax tree is what meets it."""


_LOOKED_UP = frozenset(
    (
        *("exists", "isfile", "isdir", "is_file", "is_dir"),
        *("listdir", "scandir", "iterdir", "glob", "iglob", "rglob"),
        *("stat", "lstat", "access", "getsize", "getmtime", "walk", "fwalk"),
        *("imread", "CDLL", "LoadLibrary", "Popen", "check_output", "check_call", "getoutput"),
        *("system", "popen", "posix_spawn", "create_subprocess_exec", "create_subprocess_shell"),
    )
)
"""The functions that learn of files without opening them in Python."""
_STARTED = frozenset({"subprocess.run", "subprocess.call"})
"""The functions that start programs, whose last names others have too."""
_OPENED = frozenset({"open", "Path", "load", "loadtxt", "expanduser"})
"""The functions that are given a path, which may lead out of the workspace."""


def _looks_up(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    name, first = last_name(node.func), next(iter(node.args), None)
    is_path = isinstance(first, ast.Constant) and str(first.value).startswith(("/", "~", "../"))
    is_started = dotted_name(node.func) in _STARTED
    return is_started or name in _LOOKED_UP or (name in _OPENED and is_path)


def _is_left_in_its_middle(node: ast.AST) -> bool:
    if not isinstance(node, ast.While) or not isinstance(node.test, ast.Constant):
        return False
    return any(map(_breaks, node.body[1:-1]))


def _breaks(node: ast.AST) -> bool:
    """Return whether a statement can leave the loop around it."""
    if isinstance(node, (ast.For, ast.AsyncFor, ast.While, ast.FunctionDef, ast.ClassDef)):
        return False
    return isinstance(node, ast.Break) or any(map(_breaks, ast.iter_child_nodes(node)))


ANOMALIES = (
    Anomaly(
        "K1",
        "a `while True` of your controller has a `break` before its last statement",
        _is_left_in_its_middle,
    ),
    Anomaly(
        "K2",
        "your controller asks whether files exist, lists folders, starts programs, or reads files "
        "by a compiled library or of the system",
        _looks_up,
    ),
)
"""The known anomalies, sorted by number, with the words of docs/safety.md."""


def met_anomalies(sources: Mapping[str, bytes]) -> Iterator[str]:
    """Yield for each anomaly whom it concerns, and the lines of the sources that may meet it.

    `sources` are Python files by name; what does not parse has no lines.
    """
    for anomaly in ANOMALIES:
        lines = places(sources, anomaly.is_met)
        none = "no such line was found in `files/`, which proves nothing"
        at = f"look at {', '.join(lines)}" if lines else none
        yield f"{anomaly.number} concerns you if {anomaly.concerns}: {at}"
