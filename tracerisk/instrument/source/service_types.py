"""The type of a service that a source waits for by its name alone, as it stands further down.

`rospy.wait_for_service("detect")` names no type; the `ServiceProxy("detect", Trigger)` that is made
afterwards does.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import last_name
from tracerisk.instrument.source.literals.called_functions import source_tree
from tracerisk.instrument.source.python_source import parsed

_SERVICES = "srv"


def lines_of_function(place: Location) -> tuple[int, int]:
    """Return the first and last line of the innermost function in which a place is; none: 0, -1."""
    tree, line = source_tree(place), place.line or 0
    functions = (
        (node.lineno, node.end_lineno or node.lineno)
        for node in (() if tree is None else ast.walk(tree))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    )
    return max(
        (function for function in functions if function[0] <= line <= function[1]), default=(0, -1)
    )


def service_type(name: str, waited_at: Location | None) -> str:
    """Return the type of the service `name` that a source waits for; empty where it shows none.

    It is that of a proxy of the same name, given as a text or by the same expression.
    """
    if waited_at is None:
        return ""
    try:
        tree = parsed(file_bytes(Path(waited_at.file)))
    except OSError:
        return ""
    if tree is None:
        return ""
    waited = {
        ast.dump(call.args[0])
        for call in _calls(tree, "wait_for_service")
        if call.args and call.lineno <= (waited_at.line or 0) <= (call.end_lineno or call.lineno)
    }
    imported = dict(_imported(tree))
    for call in _calls(tree, "ServiceProxy"):
        given = {keyword.arg: keyword.value for keyword in call.keywords}
        named = call.args[0] if call.args else given.get("name")
        kind = call.args[1] if len(call.args) > 1 else given.get("service_class")
        if named is None or kind is None:
            continue
        is_text = isinstance(named, ast.Constant) and isinstance(named.value, str)
        if ast.dump(named) in waited or (is_text and _is_called(name, ast.literal_eval(named))):
            text = _type(kind, imported)
            if isinstance(kind, ast.Name) and kind.id not in imported:
                text = starred_type(tree, _SERVICES, kind.id)
            if text:
                return text
    return ""


def starred_type(tree: ast.AST, folder: str, name: str) -> str:
    """Return the type that `from package.srv import *` brings; empty for none, and for several.

    `folder` is `msg`, `srv` or `action`. Types begin with a capital letter, variables do not.
    """
    if not name.isidentifier() or not name[0].isupper():
        return ""
    packages = {
        node.module.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and not node.level
        if node.module.endswith(f".{folder}") and node.names[0].name == "*"
    }
    return f"{packages.pop()}/{name}" if len(packages) == 1 else ""


def _calls(tree: ast.AST, function: str) -> Iterator[ast.Call]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and last_name(node.func) == function:
            yield node


def _imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield each imported name with the dotted one that it stands for."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.asname or alias.name, alias.name
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                yield alias.asname or alias.name, f"{node.module}.{alias.name}"


def _type(kind: ast.expr, imported: dict[str, str]) -> str:
    dotted = ast.unparse(kind)
    for known, full in imported.items():
        if dotted == known or dotted.startswith(f"{known}."):
            parts = (full + dotted[len(known) :]).split(".")
            if len(parts) == 3 and parts[1] == _SERVICES:
                return f"{parts[0]}/{parts[2]}"
    return ""


def _is_called(name: str, text: str) -> bool:
    plain = text.strip("/~")
    return bool(plain) and f"/{name.strip('/')}".endswith(f"/{plain}")
