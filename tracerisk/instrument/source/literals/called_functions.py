"""The functions of a source, and which of them a call can name."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import lru_cache, partial
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import Location
from tracerisk.instrument.source.dotted_names import imported_names
from tracerisk.instrument.source.literals.named_literals import with_named_literals
from tracerisk.instrument.source.literals.package_settings import package_settings
from tracerisk.instrument.source.python_source import parsed


def source_tree(place: Location | None) -> ast.Module | None:
    """Return the tree of the source in which a place is; None where it cannot be read."""
    if place is None:
        return None
    try:
        stat = Path(place.file).stat()
    except (OSError, ValueError):
        return None
    return _parsed(place.file, stat.st_mtime_ns, stat.st_size)


@lru_cache(maxsize=32)
def _parsed(file: str, changed_ns: int, size: int) -> ast.Module | None:
    """Return the tree of a source as it is; `changed_ns` and `size` are keys of the cache."""
    del changed_ns, size
    path = Path(file)
    try:
        tree = parsed(file_bytes(path))
    except OSError:
        return None
    return None if tree is None else with_named_literals(tree, partial(package_settings, path))


def calls_at(tree: ast.AST, line: int | None) -> Iterator[ast.Call]:
    """Yield the calls of a tree that stand, or go on, at a line."""
    for call in _calls_in(tree) if line is not None else ():
        if call.lineno <= (line or 0) <= (call.end_lineno or call.lineno):
            yield call


@lru_cache(maxsize=32)
def _calls_in(tree: ast.AST) -> tuple[ast.Call, ...]:
    return tuple(node for node in ast.walk(tree) if isinstance(node, ast.Call))


Function = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda


@lru_cache(maxsize=32)
def functions_of(tree: ast.AST) -> Mapping[str, Function]:
    """Return the functions of a source by name."""
    return {
        node.name: node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    }


def functions_imported(tree: ast.Module, file: Path) -> dict[str, Function]:
    """Return the functions of a source that it has from files near it, with what these call."""
    imported_functions: dict[str, Function] = {}
    for name, there, path in imported_names(tree, file):
        inner = source_tree(Location(str(path)))
        own = {} if inner is None else functions_of(inner)
        if there in own:
            imported_functions |= {
                other: function
                for other, function in own.items()
                if other not in imported_functions
            }
            imported_functions[name] = own[there]
    return imported_functions


def parameter_name(function: Function, number: int) -> str | None:
    """Return the name of a parameter, counted from 0 behind `self`; None where there is none."""
    names = [parameter.arg for parameter in (*function.args.posonlyargs, *function.args.args)]
    if names[:1] in (["self"], ["cls"]):
        del names[0]
    return names[number] if number < len(names) else None
