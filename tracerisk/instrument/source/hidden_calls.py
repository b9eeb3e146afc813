"""Calls that may command by another name than that of the command: nobody can read which it is.

`getattr(arm, name)()`, `move = arm.go` and then `move()`, `exec(text)`. A dynamic name of `self`,
of a class or of a module leads to functions of the program, which count by themselves.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator

from tracerisk.instrument.source.dotted_names import last_name

EXECUTED = frozenset({"eval", "exec"})
"""The built-in functions that execute a text."""
_IMPORTED = frozenset({"__import__", "import_module"})
_BY_NAME = {"getattr": 1, "methodcaller": 0, "attrgetter": 0, "__getattribute__": 0}
"""The functions that find something by its name, and which argument is the name."""
_RUN_LATER = frozenset({"Process", "Thread", "Timer", "map", "partial", "starmap", "submit"})
_LOOKED_UP = frozenset({"get", "pop"})
_OF_PROGRAM = frozenset({"self", "cls"})


def hidden_calls(tree: ast.Module, motion: Collection[str]) -> Iterator[ast.Call]:
    """Yield these calls of a source; `motion` are the last names of calls that command motion."""
    handles = _Handles(tree, motion)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and handles.may_be_called_by(node):
            yield node


class _Handles:
    """Which expressions of a source may be what commands, by a name that is not its own."""

    def __init__(self, tree: ast.Module, motion: Collection[str]) -> None:
        self._motion = frozenset(motion)
        self._modules = {
            alias.asname or alias.name.partition(".")[0]
            for node in ast.walk(tree)
            if isinstance(node, ast.Import)
            for alias in node.names
        }
        self._names: set[str] = set()
        for node in ast.walk(tree):
            match node:
                case ast.Assign(targets=targets, value=value):
                    pass
                case (
                    ast.AnnAssign(target=target, value=ast.expr() as value)
                    | ast.NamedExpr(target=target, value=value)
                ):
                    targets = [target]
                case _:
                    continue
            if any(map(self._is_handle, _parts(value))):
                self._names |= {last_name(target) for target in targets} - {""}

    def may_be_called_by(self, call: ast.Call) -> bool:
        """Return whether a call calls such a thing, or hands it to what calls it."""
        name = last_name(call.func)
        if isinstance(call.func, ast.Name) and name in EXECUTED:
            text = _text(next(iter(call.args), None))
            return text is None or any(word in text for word in self._motion)
        if name in _IMPORTED:
            return _text(next(iter(call.args), None)) is None
        if name in _RUN_LATER:
            values = [*call.args, *(keyword.value for keyword in call.keywords)]
            return any(isinstance(value, ast.Call) and self._is_handle(value) for value in values)
        called = _looked_up_in(call.func)
        if isinstance(called, ast.Call):
            return self._is_handle(called)
        return last_name(called) in self._names or (
            called is not call.func and any(map(self._is_handle, _parts(called)))
        )

    def _is_handle(self, node: ast.expr) -> bool:
        if isinstance(node, ast.Attribute):
            return node.attr in self._motion
        if not isinstance(node, ast.Call) or last_name(node.func) not in _BY_NAME:
            return False
        at = _BY_NAME[last_name(node.func)]
        if len(node.args) <= at:
            return False
        text = _text(node.args[at])
        if text is not None:
            return text.rpartition(".")[2] in self._motion
        return at == 0 or not self._is_of_program(node.args[0])

    def _is_of_program(self, node: ast.expr) -> bool:
        return isinstance(node, ast.Name) and node.id in (_OF_PROGRAM | self._modules)


def _parts(value: ast.expr) -> Iterator[ast.expr]:
    """Yield what an expression may be, and the items of a table."""
    match value:
        case ast.IfExp(body=left, orelse=right):
            inner = [left, right]
        case ast.BoolOp(values=inner) | ast.Tuple(elts=inner) | ast.List(elts=inner):
            pass
        case ast.Dict(values=inner):
            pass
        case _:
            yield value
            return
    for part in inner:
        yield from _parts(part)


def _looked_up_in(function: ast.expr) -> ast.expr:
    """Return the table in which what is called is looked up, else what is called."""
    match function:
        case ast.Subscript(value=table):
            return table
        case ast.Call(func=ast.Attribute(value=table, attr=name)) if name in _LOOKED_UP:
            return table
    return function


def _text(node: ast.expr | None) -> str | None:
    """Return the text that an expression is, `None` for one that is made as the program runs."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            texts = (_text(left), _text(right))
            return None if None in texts else "".join(map(str, texts))
    return None
