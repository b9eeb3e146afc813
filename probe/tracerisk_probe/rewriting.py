"""Add a tracing decorator to each function of a source, in memory.

The syntax tree is changed and not the text, so lines and columns are those of the file.
"""

from __future__ import annotations

import ast
from types import CodeType
from typing import Iterator, Union

DECORATOR = "__tracerisk_probe_traced__"
"""The name of the decorator in traced modules; not mangled in classes, hidden from `*`."""

# What these make of a function no longer runs as Python, and cannot command an arm.
_COMPILING = frozenset({"jit", "njit", "vectorize", "guvectorize", "cfunc", "stencil"})

AnyDef = Union[ast.FunctionDef, ast.AsyncFunctionDef]


def compile_traced(source: bytes, file: str, filename: str) -> CodeType:
    """Return the code of a module whose functions are traced.

    `file` is what its stacks call it, `filename` where it lies.
    Raises SyntaxError or ValueError where Python would.
    """
    tree = ast.parse(source, filename)
    found = list(_functions(tree, ""))
    for node, name in found:
        if not any(_last_name(each) in _COMPILING for each in node.decorator_list):
            node.decorator_list.append(_decorator(node, file, name))
    if found:
        tree.body.insert(_import_index(tree), _import())
    return compile(tree, filename, "exec", dont_inherit=True)


def _functions(node: ast.AST, prefix: str) -> Iterator[tuple[AnyDef, str]]:
    pending: list[tuple[ast.AST, str]] = [(node, prefix)]
    while pending:
        above, before = pending.pop()
        for child in ast.iter_child_nodes(above):
            if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
                name = before + child.name
                yield child, name
                pending.append((child, f"{name}.<locals>."))
            elif isinstance(child, ast.ClassDef):
                pending.append((child, f"{before}{child.name}."))
            else:
                pending.append((child, before))


def _last_name(node: ast.expr) -> str:
    if isinstance(node, ast.Call):
        node = node.func
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _decorator(node: AnyDef, file: str, name: str) -> ast.expr:
    call = ast.Call(
        ast.Name(DECORATOR, ast.Load()),
        [ast.Constant(file, None), ast.Constant(name, None), ast.Constant(node.lineno, None)],
        [],
    )
    for each in ast.walk(call):
        if isinstance(each, ast.expr):
            each.lineno = each.end_lineno = node.lineno
            each.col_offset = each.end_col_offset = node.col_offset
    return call


def _import() -> ast.stmt:
    alias = ast.alias("traced", DECORATOR)
    line = ast.ImportFrom(f"{__package__}.stacks", [alias], 0)
    for each in (line, alias):
        each.lineno = each.end_lineno = 1
        each.col_offset = each.end_col_offset = 0
    return line


def _import_index(tree: ast.Module) -> int:
    """Count the docstring and the `from __future__` imports, which must stay first."""
    index = 1 if ast.get_docstring(tree, clean=False) is not None else 0
    while index < len(tree.body):
        each = tree.body[index]
        if not (isinstance(each, ast.ImportFrom) and each.module == "__future__"):
            break
        index += 1
    return index
