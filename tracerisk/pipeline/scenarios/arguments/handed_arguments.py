"""Where a source hands its command line on: `main(sys.argv[1:])`, `args = sys.argv[1:]`."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator, Mapping

from tracerisk.instrument.source.dotted_names import last_name

_MOST_ROUNDS = 5  # functions that hand it on to each other
_ARGV = "sys.argv"

_Function = ast.FunctionDef | ast.AsyncFunctionDef
_Aliases = dict[str, int]
"""Names that hold the command line, each with the index of their first word."""


def with_plain_argv(tree: ast.Module) -> ast.Module:
    """Return a source in which words of the command line are read of `sys.argv` itself.

    `args[0]` is `sys.argv[1]` in a function that is called with `sys.argv[1:]`.
    """
    functions = {node.name: node for node in ast.walk(tree) if isinstance(node, _Function)}
    known: dict[str, _Aliases] = {name: {} for name in functions}
    for _ in range(_MOST_ROUNDS):
        merged = {name: dict(fields) for name, fields in known.items()}
        for scope, aliases in _scopes(tree, known):
            for name, given in _handed(scope, aliases, functions):
                merged[name].update(given)
        if merged == known:
            break
        known = merged
    if not any(aliases for _, aliases in _scopes(tree, known)):
        return tree
    plain = copy.deepcopy(tree)
    for scope, aliases in _scopes(plain, known):
        _Plain(aliases).visit(scope)
    return plain


def _scopes(tree: ast.Module, known: Mapping[str, _Aliases]) -> Iterator[tuple[ast.AST, _Aliases]]:
    """Yield the functions of a source, then the source, each with the names that hold words."""
    for node in ast.walk(tree):
        if isinstance(node, _Function):
            yield node, {**known[node.name], **_assigned(node, known[node.name])}
    yield tree, _assigned(tree, {})


def _assigned(scope: ast.AST, aliases: _Aliases) -> _Aliases:
    """Return the names that are given the rest of the command line in a scope."""
    starts: _Aliases = {}
    for node in _within(scope):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            start = _start(node.value, {**aliases, **starts})
            if start is not None and isinstance(node.targets[0], ast.Name):
                starts[node.targets[0].id] = start
    return starts


def _within(scope: ast.AST) -> Iterator[ast.AST]:
    """Yield what is in a scope, but for the functions in it."""
    for node in ast.iter_child_nodes(scope):
        if not isinstance(node, _Function):
            yield node
            yield from _within(node)


def _start(node: ast.expr, aliases: _Aliases) -> int | None:
    """Return at which word of the command line an expression begins, `None` for no part of it."""
    if ast.unparse(node) == _ARGV:
        return 0
    if isinstance(node, ast.Name):
        return aliases.get(node.id)
    if isinstance(node, ast.Call) and last_name(node.func) == "myargv":
        return 0
    if not isinstance(node, ast.Subscript) or not isinstance(node.slice, ast.Slice):
        return None
    base, lower = _start(node.value, aliases), node.slice.lower
    if base is None or node.slice.upper is not None or node.slice.step is not None:
        return None
    if lower is None:
        return base
    if isinstance(lower, ast.Constant) and isinstance(lower.value, int) and lower.value >= 0:
        return base + lower.value
    return None


def _handed(
    scope: ast.AST,
    aliases: _Aliases,
    functions: Mapping[str, _Function],
) -> Iterator[tuple[str, _Aliases]]:
    """Yield the functions that are called with the command line, each with its parameter."""
    for node in _within(scope):
        if not isinstance(node, ast.Call):
            continue
        called = functions.get(last_name(node.func))
        if called is None:
            continue
        names = [argument.arg for argument in called.args.args]
        if names[:1] in (["self"], ["cls"]):
            names = names[1:]
        pairs = [
            *zip(names, node.args, strict=False),
            *((keyword.arg, keyword.value) for keyword in node.keywords if keyword.arg),
        ]
        for name, value in pairs:
            start = _start(value, aliases)
            if start is not None:
                yield called.name, {name: start}


class _Plain(ast.NodeTransformer):
    """Puts `sys.argv` where a name holds the command line, with the index that it has there."""

    def __init__(self, aliases: _Aliases) -> None:
        self._aliases = aliases
        self._is_inner = False

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, _Function) and self._is_inner:
            return node
        self._is_inner = True
        result: ast.AST = super().visit(node)
        return result

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        start = self._aliases.get(node.value.id) if isinstance(node.value, ast.Name) else None
        index = node.slice
        if start is None or not isinstance(index, ast.Constant) or not isinstance(index.value, int):
            return node
        if index.value < 0:
            return node
        argv = ast.Attribute(ast.Name("sys", ast.Load()), "argv", ast.Load())
        plain = ast.Subscript(argv, ast.Constant(index.value + start), node.ctx)
        return ast.fix_missing_locations(ast.copy_location(plain, node))
