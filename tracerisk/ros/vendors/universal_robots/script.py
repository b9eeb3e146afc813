"""Programs in URScript, as far as they go straight on: calls, values, and names for these."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

_POSE = "p"  # p[x, y, z, rx, ry, rz] is a pose
_HEAD = re.compile(r"(?:def|sec)\s+(\w+)\s*\(\s*\)\s*:")
_BRANCHES = re.compile(r"(?:if|elif|else|while|for|thread|run|return|break|continue|halt)\b")
_NAMED = re.compile(r"(?:global\s+|local\s+)?([A-Za-z_]\w*)\s*=(?!=)\s*(.+)")
_OPERATIONS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}


class ScriptError(Exception):
    """What is not understood of a program, with its line."""


class PoseNumbers(list[float]):
    """The six numbers of a pose: a place [m] and a rotation vector [rad]."""


@dataclass(frozen=True, slots=True)
class Statement:
    """A statement of a program."""

    line: int
    """The line of the program, from 1."""
    name: str
    """The variable that takes the value; empty for a mere call."""
    expression: ast.expr
    """The expression, parsed as Python."""


def statements(text: str) -> list[Statement]:
    """Return the statements of a program in their order.

    Raises:
        ScriptError: it branches, or is malformed.
    """
    result: list[Statement] = []
    programs: set[str] = set()
    for number, full in enumerate(text.splitlines(), 1):
        line = full.partition("#")[0].strip().rstrip(";").rstrip()
        head = _HEAD.fullmatch(line)
        if head is not None:
            programs.add(head[1])
            continue
        if not line or line == "end" or line.removesuffix("()") in programs:
            continue
        branch = _BRANCHES.match(line)
        if branch is not None:
            raise ScriptError(f"line {number} of the program: '{branch[0]}' is not simulated")
        named = _NAMED.fullmatch(line)
        name, expression = (named[1], named[2]) if named is not None else ("", line)
        try:
            parsed = ast.parse(expression, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise ScriptError(f"line {number} of the program is malformed: {line[:60]}") from None
        result.append(Statement(number, name, parsed))
    return result


def evaluate(
    statement: Statement, names: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]
) -> Any:
    """Return what an expression comes to; `functions` are those that may be called.

    Raises:
        ScriptError: it holds what is not simulated.
    """

    def value(node: ast.expr) -> Any:
        match node:
            case ast.Constant(value=bool() | int() | float() | str() as constant):
                return constant
            case ast.Name(id=name) if name in names:
                return names[name]
            case ast.Name(id="pi"):
                return math.pi
            case ast.List(elts=parts) | ast.Tuple(elts=parts):
                return [value(part) for part in parts]
            case ast.Subscript(value=ast.Name(id=name), slice=ast.Tuple(elts=parts)) if (
                name == _POSE
            ):
                return PoseNumbers(float(value(part)) for part in parts)
            case ast.Subscript(value=of, slice=index):
                return value(of)[int(value(index))]
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -value(operand)
            case ast.BinOp(left=left, op=operation, right=right) if type(operation) in _OPERATIONS:
                return _OPERATIONS[type(operation)](float(value(left)), float(value(right)))
            case ast.Call(func=ast.Name(id=name), args=given, keywords=keywords):
                if name not in functions:
                    raise ScriptError(f"'{name}' is not simulated")
                more = {str(keyword.arg): value(keyword.value) for keyword in keywords}
                return functions[name](*map(value, given), **more)
        raise ScriptError(f"'{ast.unparse(node)[:60]}' is not simulated")

    try:
        return value(statement.expression)
    except ScriptError as error:
        raise ScriptError(f"line {statement.line} of the program: {error}") from None
    except (TypeError, ValueError, IndexError, ArithmeticError, RecursionError) as error:
        raise ScriptError(f"line {statement.line} of the program: {error}") from None
