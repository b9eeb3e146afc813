"""The function that starts a controller which is installed as a command, not run as a script.

A build makes a small program of each `console_scripts` entry that imports the module and calls
the function; run as a script such a module would only define it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.workspace.console_scripts import console_scripts

_MAIN = "main"


@dataclass(frozen=True, slots=True)
class EntryPoint:
    """A function without required arguments that starts a controller."""

    function: str
    """The name of the function in the module."""
    named_in: str | None
    """The file that names it, such as `setup.py`; `None` where it is only called `main`."""


def find_entry_point(script: Path, source: bytes, root: Path) -> EntryPoint | None:
    """Return the function to call once the module-level code of `script` has run.

    That is the one that `setup.py`, `setup.cfg` or `pyproject.toml` in `root` names for this
    module, else `main`. `None` where the script starts by itself: it asks for its `__name__`, or
    its module-level code calls that function, or of one that nothing names any of its own.
    """
    tree = parsed(source)
    if tree is None:
        return None
    startable = {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and not _required(node.args)
    }
    if not startable or _asks_for_its_name(tree):
        return None
    called = _called_at_once(tree)
    for console_script in console_scripts(root):
        if console_script.module == script.stem and console_script.function in startable:
            is_called = console_script.function in called
            return None if is_called else EntryPoint(console_script.function, console_script.file)
    return EntryPoint(_MAIN, None) if _MAIN in startable and not called else None


def _required(arguments: ast.arguments) -> bool:
    positional = len(arguments.posonlyargs) + len(arguments.args) - len(arguments.defaults)
    return positional > 0 or any(default is None for default in arguments.kw_defaults)


def _asks_for_its_name(tree: ast.Module) -> bool:
    # Not as in `get_logger(__name__)`, which starts nothing.
    return any(
        isinstance(node, ast.Name) and node.id == "__name__" and _is_compared(tree, node)
        for node in _module_level(tree)
    )


def _called_at_once(tree: ast.Module) -> set[str]:
    """Return which of its functions and classes the module-level code calls."""
    defined = {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
    }
    return defined & {
        node.func.id
        for node in _module_level(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }


def _is_compared(tree: ast.Module, name: ast.Name) -> bool:
    return any(
        name in (node.left, *node.comparators)
        for node in _module_level(tree)
        if isinstance(node, ast.Compare)
    )


def _module_level(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield the nodes that run with the module: all but what is within functions and classes."""
    waiting: list[ast.AST] = list(tree.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda):
            continue
        yield node
        waiting.extend(ast.iter_child_nodes(node))
