"""Where the functions of a parsed Python source stand, and which one is around a line."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tracerisk.common.function_ref import QualifiedName

MODULE = QualifiedName("<module>")
"""The pseudo-function that module-level code is."""

_LEAVES = frozenset(
    {
        *(ast.Expr, ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Return, ast.Import),
        *(ast.ImportFrom, ast.Pass, ast.Raise, ast.Assert, ast.Delete, ast.Global),
        *(ast.Nonlocal, ast.Break, ast.Continue),
    }
)


class Definition(NamedTuple):
    """One `def` or `async def`."""

    name: QualifiedName
    """The qualified name of the function."""
    line: int
    """The line of the `def`, from 1."""
    body_line: int
    """The first line of the first statement, decorators included, from 1."""
    first_line: int
    """The first line of the definition, decorators included, from 1."""
    last_line: int
    """The last line of the body, from 1."""


def normal_name(name: str) -> str:
    """Return `name` as Python compares identifiers (NFKC)."""
    if name.isascii():
        return name
    from unicodedata import normalize

    return normalize("NFKC", name)


def first_line(statement: ast.stmt) -> int:
    """Return the first line of a statement, decorators included."""
    decorators: Sequence[ast.expr] = getattr(statement, "decorator_list", ())
    return min([statement.lineno, *(decorator.lineno for decorator in decorators)])


def definitions(tree: ast.Module) -> Iterator[Definition]:
    """Yield every function definition of the module in the order of the source."""
    for name, node in functions_of(tree):
        yield Definition(
            name,
            node.lineno,
            first_line(node.body[0]),
            first_line(node),
            node.end_lineno or node.lineno,
        )


def functions_of(
    tree: ast.Module,
) -> Iterator[tuple[QualifiedName, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Yield every function of the module by its qualified name, in the order of the source."""
    # Most children cannot hold a statement, so they are skipped.
    stack: list[tuple[ast.AST, str]] = [(tree, "")]
    while stack:
        node, prefix = stack.pop()
        inner = prefix
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            name = f"{prefix}{node.name}"
            yield QualifiedName(name), node
            inner = f"{name}.<locals>."
        elif isinstance(node, ast.ClassDef):
            inner = f"{prefix}{node.name}."
        stack += [(child, inner) for child in reversed(_inner(node))]


def _inner(node: ast.AST) -> list[ast.AST]:
    """Return what stands directly within a node and can hold statements."""
    children: list[ast.AST] = []
    for part in ("body", "handlers", "orelse", "finalbody", "cases"):
        result = getattr(node, part, None)
        if isinstance(result, list):
            children += result
    return [child for child in children if type(child) not in _LEAVES]


def function_at(tree: ast.Module, line: int) -> QualifiedName:
    """Return the innermost function around a line; the module's pseudo-function outside all."""
    function, prefix = MODULE, ""
    around: list[ast.AST] = [tree]
    while around:
        node = around.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            prefix += node.name
            if isinstance(node, ast.ClassDef):
                prefix += "."
            else:
                function = QualifiedName(prefix)
                prefix += ".<locals>."
            around.clear()
        # The cases of a `match` have no lines.
        around += [
            child
            for child in reversed(_inner(node))
            if getattr(child, "lineno", line) <= line <= (getattr(child, "end_lineno", 0) or line)
        ]
    return function
