"""Mark the calls that may issue commands, so that a run notes which of them it executed.

A mark is evaluated before everything else in its call: `(mark(key), self)[1].arm.go()`. So the call
keeps its place, its value and its line, and no frame comes between. What cannot issue a command has
no mark: a built-in function, one of Python's own modules, a line of a log.
"""

from __future__ import annotations

import ast
import builtins
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import CodeType

from tracerisk.instrument.code_positions import call_position
from tracerisk.instrument.marks.call_log import Site, call_key
from tracerisk.instrument.marks.endless_loops import import_into
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.hidden_calls import EXECUTED

MARK = "__tracerisk_called__"
"""The name of the mark in instrumented code; not mangled in classes, hidden from `*`."""
MADE = "__tracerisk_made__"
"""The name of what notes where a generator or a coroutine was made."""
COMPILING_DECORATORS = frozenset({"jit", "njit", "vectorize", "guvectorize", "cfunc", "stencil"})
"""What these make of a function no longer runs as Python, and cannot command an arm."""

Function = ast.FunctionDef | ast.AsyncFunctionDef
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_ANNOTATIONS = frozenset({"annotation", "returns", "type_params"})
_NUMBERS = frozenset({"numpy", "scipy"})
_LOG = re.compile(r"log_?(debug|info|warn|err|fatal)|(debug|info|warn|warning|error|fatal)$")


@dataclass(frozen=True, slots=True)
class MarkedCall:
    """A call of a source that may command."""

    node: ast.Call
    """The call in the syntax tree."""
    scope: Function | None
    """The function around it, `None` in module-level code."""
    is_spare: bool
    """Whether it is in an `except` clause, or in what only a script executes."""
    replace: Callable[[ast.expr], None]
    """Puts another expression in its place."""

    @property
    def site(self) -> Site:
        """Where the run finds it."""
        line, column = call_position(self.node)
        return line, column + 1


def marked_calls(tree: ast.Module) -> Iterator[MarkedCall]:
    """Yield the calls of a source that may command; none of an annotation."""
    names = _Names(tree)
    pending: list[tuple[ast.AST, Function | None, bool]] = [(tree, None, False)]
    while pending:
        node, scope, is_spare = pending.pop()
        for name, value in ast.iter_fields(node):
            if name in _ANNOTATIONS:
                continue
            inner = (scope, is_spare)
            if name == "body" and isinstance(node, _FUNCTIONS):
                inner = (node, False)
            elif name == "body":
                inner = (scope, is_spare or _is_spare(node))
            for index, child in enumerate(value if isinstance(value, list) else [value]):
                if not isinstance(child, ast.AST) or is_compiled(child):
                    continue
                pending.append((child, *inner))
                if isinstance(child, ast.Call) and names.may_command(child.func):
                    replace = _replacer(node, name, index if isinstance(value, list) else None)
                    yield MarkedCall(child, *inner, replace)


def mark_calls(tree: ast.Module, module: str, file: str, inserted: frozenset[str]) -> None:
    """Insert the marks, imported from `module`; calls by the names `inserted` get none."""
    lazy = {node.name for node in ast.walk(tree) if isinstance(node, _FUNCTIONS) and is_lazy(node)}
    used = {}
    for call in list(marked_calls(tree)):
        name = last_name(call.node.func)
        if name in inserted:
            continue
        key = ast.Constant(call_key(file, call.site))
        mark = ast.Name(MADE if name in lazy else MARK, ast.Load())
        used[mark.id] = "made" if name in lazy else "called"
        replace_first, first = _first_evaluated(call.node)
        if name in lazy:
            marked = ast.Call(mark, [key, call.node], [])
            _place(first, mark, key)
            ast.copy_location(marked, call.node)
            marked.lineno, marked.col_offset = call_position(call.node)
            call.replace(marked)
        else:
            noted = ast.Call(mark, [key], [])
            both, second = ast.Tuple([noted, first], ast.Load()), ast.Constant(1)
            marked_first = ast.Subscript(both, second, ast.Load())
            _place(first, noted, mark, key, both, second, marked_first)
            replace_first(marked_first)
    import_into(tree, module, {used[name]: name for name in sorted(used)})


class _Names:
    """What the names of a source stand for, as far as it decides whether a call may command."""

    def __init__(self, tree: ast.Module) -> None:
        self._plain: set[str] = set()
        """Python's own modules and what is imported from them."""
        self._own: set[str] = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                self._import(node)
            elif isinstance(node, (*_FUNCTIONS, ast.ClassDef)):
                self._own.add(node.name)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                self._own.add(node.id)
            elif isinstance(node, ast.arg):
                self._own.add(node.arg)

    def _import(self, node: ast.Import | ast.ImportFrom) -> None:
        for alias in node.names:
            is_from = isinstance(node, ast.ImportFrom)
            module = (node.module or "") if isinstance(node, ast.ImportFrom) else alias.name
            name = alias.asname or (alias.name if is_from else alias.name.partition(".")[0])
            top = module.partition(".")[0]
            is_python = top in sys.stdlib_module_names or top in _NUMBERS
            is_own = isinstance(node, ast.ImportFrom) and node.level > 0
            (self._plain if is_python and not is_own else self._own).add(name)

    def may_command(self, function: ast.expr) -> bool:
        """Return whether a call of what an expression names may command."""
        root = dotted_name(function).partition(".")[0]
        if isinstance(function, ast.Name) and root in EXECUTED:
            return True
        if root in self._own:
            return not self._is_log(function)
        if root in self._plain or (isinstance(function, ast.Name) and hasattr(builtins, root)):
            return False
        return not self._is_log(function)

    def _is_log(self, function: ast.expr) -> bool:
        name = last_name(function)
        return name not in self._own and bool(_LOG.match(name))


def _is_spare(node: ast.AST) -> bool:
    if isinstance(node, ast.If):
        names = {name.id for name in ast.walk(node.test) if isinstance(name, ast.Name)}
        return "__name__" in names
    return isinstance(node, ast.ExceptHandler)


def is_compiled(node: ast.AST) -> bool:
    """Return whether a decorator makes something else than Python of a function."""
    return isinstance(node, _FUNCTIONS) and any(
        last_name(decorator.func if isinstance(decorator, ast.Call) else decorator)
        in COMPILING_DECORATORS
        for decorator in node.decorator_list
    )


def is_lazy(function: Function) -> bool:
    """Return whether a function's body begins later than its call."""
    if isinstance(function, ast.AsyncFunctionDef):
        return True
    pending: list[ast.AST] = list(function.body)
    while pending:
        node = pending.pop()
        if isinstance(node, ast.Yield | ast.YieldFrom):
            return True
        if not isinstance(node, (*_FUNCTIONS, ast.Lambda)):
            pending += ast.iter_child_nodes(node)
    return False


def _replacer(parent: ast.AST, name: str, index: int | None) -> Callable[[ast.expr], None]:
    def replace(node: ast.expr) -> None:
        if index is None:
            setattr(parent, name, node)
        else:
            getattr(parent, name)[index] = node

    return replace


def _first_evaluated(call: ast.Call) -> tuple[Callable[[ast.expr], None], ast.expr]:
    """Return what of a call is evaluated first, and what puts another expression in its place."""
    parent: ast.expr = call
    name = "func"
    while True:
        node = getattr(parent, name)
        inner = _FIRST.get(type(node))
        if inner is None:
            return _replacer(parent, name, None), node
        parent, name = node, inner


_FIRST = {ast.Call: "func", ast.Attribute: "value", ast.Subscript: "value"}


def _place(place: ast.expr, *nodes: ast.expr) -> None:
    for node in nodes:
        ast.copy_location(node, place)


def has_marks(code: CodeType) -> bool:
    """Return whether calls are marked in a function, or in what stands in it."""
    inner = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    return bool({MARK, MADE} & set(code.co_names)) or any(map(has_marks, inner))
