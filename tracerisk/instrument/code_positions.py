"""Where in its source an instruction is, and the qualified name of a code object.

Python 3.11 and later keep both in the code object; Python 3.10 keeps lines alone.
There `compile_with_positions` compiles the tree once more, with the number of a node in place of
each line: the instructions are the same, and each names its node.
What it finds goes into a last constant of the code object, which no instruction loads.
"""

from __future__ import annotations

import ast
import copy
import dis
import itertools
import sys
import warnings
from collections.abc import Iterator, Mapping
from types import CodeType, FunctionType
from typing import Any

Position = tuple[int | None, int | None]
"""Line from 1 and column from 0 (in UTF-8 bytes); `None` where unknown."""

_MARK = "positions of tracerisk"
_NOWHERE: Position = (None, None)
_IS_FUNCTION = 0x1  # CO_OPTIMIZED: not the body of a class or a module
# The compiler keeps or drops these by the lines around them.
_BY_LINE = frozenset({"NOP", "EXTENDED_ARG", "JUMP_ABSOLUTE", "JUMP_FORWARD"})


def compile_with_positions(tree: ast.Module, filename: str) -> CodeType:
    """Compile a tree to code that `source_position` and `qualified_name` can read."""
    code = compile(tree, filename, "exec", dont_inherit=True)
    if sys.version_info >= (3, 11):
        return code
    numbered, nodes = _numbered(tree)
    with warnings.catch_warnings():
        # The first compilation gave them.
        warnings.simplefilter("ignore")
        twin = compile(numbered, filename, "exec", dont_inherit=True)
    return _annotated(code, twin, nodes, "")


def source_position(code: CodeType, instruction: int) -> Position:
    """Return where the instruction at an offset (a frame's `f_lasti`) is in the source."""
    if sys.version_info >= (3, 11):
        places = itertools.islice(code.co_positions(), max(instruction, 0) // 2, None)
        result = next(places, None)
        return _NOWHERE if result is None else (result[0], result[2])
    return next((place for at, place in _annotation(code)[1] if at == instruction), _NOWHERE)


def call_position(call: ast.Call) -> tuple[int, int]:
    """Return the position that `source_position` reports while the call runs.

    Where a name behind a dot is on a later line than what precedes the dot, it is at that name.
    """
    named = call.func
    if isinstance(named, ast.Attribute) and _is_plain(call) and named.lineno != named.end_lineno:
        return named.end_lineno or 0, (named.end_col_offset or 0) - len(named.attr.encode())
    return call.lineno, call.col_offset


def qualified_name(code: CodeType, namespace: Mapping[str, Any]) -> str:
    """Return the dotted name of a code object.

    `namespace` holds the globals that the code runs with.
    Python 3.10 searches them for the functions of a library, and else returns the bare name.
    """
    if sys.version_info >= (3, 11):
        return code.co_qualname
    return _annotation(code)[0] or _found_in(namespace, code) or code.co_name


def _annotation(code: CodeType) -> tuple[str, tuple[tuple[int, Position], ...]]:
    """Return the name of a code object and the places of its instructions, by their offset."""
    last = code.co_consts[-1] if code.co_consts else None
    if isinstance(last, tuple) and len(last) == 3 and last[0] == _MARK:
        return last[1], last[2]
    return "", ()


def _annotated(code: CodeType, twin: CodeType, nodes: list[ast.AST], outer: str) -> CodeType:
    """Return the code, and all code in it, with its name and the places of its instructions."""
    is_module = code.co_name == "<module>"
    name = code.co_name if is_module else outer + code.co_name
    inside = "" if is_module else f"{name}{'.<locals>' * bool(code.co_flags & _IS_FUNCTION)}."
    inner = iter([co_const for co_const in twin.co_consts if isinstance(co_const, CodeType)])
    constants = [
        _annotated(co_const, next(inner), nodes, inside)
        if isinstance(co_const, CodeType)
        else co_const
        for co_const in code.co_consts
    ]
    places = tuple(_places(code, twin, nodes))
    return code.replace(co_consts=(*constants, (_MARK, name, places)))


def _numbered(tree: ast.Module) -> tuple[ast.Module, list[ast.AST]]:
    """Return a copy of the tree whose lines are indices into a list of its nodes, and this list."""
    # Instructions of no node have line 1, or no line, which becomes 0.
    nodes: list[ast.AST] = [tree, tree]
    numbered = copy.deepcopy(tree)
    for node, twin in zip(ast.walk(tree), ast.walk(numbered), strict=True):
        if "lineno" in twin._attributes:
            twin.lineno = twin.end_lineno = len(nodes)  # type: ignore[attr-defined]
            nodes.append(node)
    return numbered, nodes


def _places(code: CodeType, twin: CodeType, nodes: list[ast.AST]) -> Iterator[tuple[int, Position]]:
    """Yield offset and place of each instruction; nothing where the compiler made other code."""
    ours, theirs = list(_instructions(code)), list(_instructions(twin))
    if [name for _, name, _ in ours] != [name for _, name, _ in theirs]:
        return
    for (offset, _, line), (_, _, number) in zip(ours, theirs, strict=True):
        yield offset, _place(nodes[number], line)


def _instructions(code: CodeType) -> Iterator[tuple[int, str, int]]:
    for start, end, line in code.co_lines():
        for offset in range(start, end, 2):
            name = dis.opname[code.co_code[offset]]
            if name not in _BY_LINE:
                yield offset, name, line or 0


def _place(node: ast.AST, line: int) -> Position:
    """Return where later versions of Python place an instruction of a node."""
    if isinstance(node, ast.Call):
        position = call_position(node)
        if position != (node.lineno, node.col_offset):
            return position
    if isinstance(node, ast.Attribute) and node.lineno != node.end_lineno:
        return node.end_lineno, (node.end_col_offset or 0) - len(node.attr.encode())
    return line or None, getattr(node, "col_offset", None)


def _is_plain(call: ast.Call) -> bool:
    return not any(isinstance(argument, ast.Starred) for argument in call.args) and all(
        keyword.arg is not None for keyword in call.keywords
    )


def _found_in(namespace: Mapping[str, Any], code: CodeType) -> str | None:
    """Return the name of the function in a module, or in one of its classes, that has this code."""
    for value in list(namespace.values()):
        for var in (value, *(vars(value).values() if isinstance(value, type) else ())):
            function = getattr(var, "fget", None) or getattr(var, "__func__", var)
            function = getattr(function, "__wrapped__", function)
            if isinstance(function, FunctionType) and function.__code__ is code:
                return function.__qualname__
    return None
