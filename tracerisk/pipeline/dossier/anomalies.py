"""Which known anomalies of docs/safety.md a figure's sources may meet, by their lines."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.python_source import parsed


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
        *("imread", "Popen", "check_output", "check_call"),
    )
)
"""The functions that learn of files without opening them in Python."""
_OPENED = frozenset({"open", "Path", "load", "loadtxt", "expanduser"})
"""The functions that are given a path, which may lead out of the workspace."""


def _looks_up(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call):
        return False
    name, first = last_name(node.func), next(iter(node.args), None)
    is_path = isinstance(first, ast.Constant) and str(first.value).startswith(("/", "~", "../"))
    return name in _LOOKED_UP or (name in _OPENED and is_path)


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
        "by a compiled library or outside of the workspace",
        _looks_up,
    ),
)
"""The known anomalies, sorted by number, with the words of docs/safety.md."""


_ENVIRONMENT = frozenset({"environ", "environb", "getenv", "getenvb"})


def reads_environment(sources: Mapping[str, bytes]) -> list[str]:
    """Return the lines of Python sources that may read a variable of the environment."""
    return _places(_trees(sources), lambda node: _names(node) in _ENVIRONMENT)


def _names(node: ast.AST) -> str:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _trees(sources: Mapping[str, bytes]) -> dict[str, ast.Module | None]:
    return {name: parsed(data) for name, data in sources.items() if name.endswith(".py")}


def _places(trees: Mapping[str, ast.Module | None], is_met: Callable[[ast.AST], bool]) -> list[str]:
    return [
        f"{name}:{line}"
        for name, tree in sorted(trees.items())
        if tree is not None
        for line in sorted({getattr(node, "lineno", 0) for node in ast.walk(tree) if is_met(node)})
    ]


def met_anomalies(sources: Mapping[str, bytes]) -> Iterator[str]:
    """Yield for each anomaly whom it concerns, and the lines of the sources that may meet it.

    `sources` are Python files by name; what does not parse has no lines.
    """
    trees = _trees(sources)
    for anomaly in ANOMALIES:
        places = _places(trees, anomaly.is_met)
        none = "no such line was found in `files/`, which proves nothing"
        at = f"look at {', '.join(places)}" if places else none
        yield f"{anomaly.number} concerns you if {anomaly.concerns}: {at}"
