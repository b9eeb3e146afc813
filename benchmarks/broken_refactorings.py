"""Refactor a controller in one place, automatically, so that it does the same as before."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Callable, Iterator

from broken_kinds import Breakage, Unbroken, _edited, _same

EXTRACT, INLINE, RENAME, DEAD = "extract", "inline", "rename", "dead code"
REFACTORINGS = (EXTRACT, INLINE, RENAME, DEAD)

_Function = ast.FunctionDef | ast.AsyncFunctionDef


def refactorings(unbroken: Unbroken) -> Iterator[Breakage]:
    """Yield every refactoring that fits a controller, in the order of the source."""
    for name, tree in unbroken.trees():
        for kind, edit, what in (*_extracts(tree), *_inlines(tree), *_renames(unbroken, tree)):
            files = _edited(unbroken, name, edit)
            if files:
                yield Breakage(kind, f"{name}: {what}", files)
        for number, function in enumerate(_functions(tree)):
            files = _edited(unbroken, name, _with_dead_code(function, number))
            if files:
                yield Breakage(DEAD, f"{name}: unused in {function.name}", files)


def _functions(tree: ast.Module) -> list[_Function]:
    return [node for node in ast.walk(tree) if isinstance(node, _Function)]


_Edit = Callable[[ast.Module], None]


def _extracts(tree: ast.Module) -> Iterator[tuple[str, _Edit, str]]:
    """Yield edits that put the last half of a body into a function of its own."""
    for holder in ast.walk(tree):
        if not isinstance(holder, ast.Module | ast.ClassDef):
            continue
        for function in holder.body:
            if not isinstance(function, _Function) or len(function.body) < 2:
                continue
            if function.decorator_list or function.args.vararg or function.args.kwarg:
                continue
            if any(isinstance(node, ast.Yield) for node in ast.walk(function)):
                continue
            for half in dict.fromkeys((len(function.body) // 2, 1)):
                yield EXTRACT, _extract(holder, function, half), f"{function.name} from {half + 1}"


def _extract(holder: ast.Module | ast.ClassDef, function: _Function, half: int) -> _Edit:
    parameters = [argument.arg for argument in function.args.args]
    set_before = {
        item.id
        for statement in function.body[:half]
        for item in ast.walk(statement)
        if isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store)
    }
    read_after = {
        item.id
        for statement in function.body[half:]
        for item in ast.walk(statement)
        if isinstance(item, ast.Name)
    }
    handed = [*parameters, *sorted((set_before & read_after) - set(parameters))]
    is_method = isinstance(holder, ast.ClassDef)

    def edit(tree: ast.Module) -> None:
        result = _same(tree, function)
        assert isinstance(result, _Function)
        rest = result.body[half:]
        name = f"{result.name}_rest"
        made = type(result)(
            name=name,
            args=ast.arguments([], [ast.arg(text) for text in handed], None, [], [], None, []),
            body=rest,
            decorator_list=[],
            returns=None,
            type_comment=None,
        )
        if hasattr(result, "type_params"):
            made.type_params = []  # type: ignore[union-attr]
        called = f"{handed[0]}.{name}" if is_method else name
        given = ", ".join(handed[1:] if is_method else handed)
        waits = "await " if isinstance(result, ast.AsyncFunctionDef) else ""
        result.body[half:] = ast.parse(f"return {waits}{called}({given})").body
        for node in ast.walk(tree):
            body = getattr(node, "body", None)
            if isinstance(body, list) and result in body:
                body.insert(body.index(result) + 1, made)
                return

    return edit


def _inlines(tree: ast.Module) -> Iterator[tuple[str, _Edit, str]]:
    """Yield edits that put a body in place of a call of a function that takes and gives nothing."""
    named = {
        function.name: function
        for function in _functions(tree)
        if isinstance(function, ast.FunctionDef)
    }
    counts = Counter(function.name for function in _functions(tree))
    for node in ast.walk(tree):
        if not isinstance(node, ast.Expr) or not isinstance(node.value, ast.Call):
            continue
        call = node.value
        owner, _, last = ast.unparse(call.func).rpartition(".")
        target = named.get(last)
        if target is None or counts[last] > 1 or owner not in ("self", "") or call.args:
            continue
        if call.keywords or any(isinstance(item, ast.Return) for item in ast.walk(target)):
            continue
        if len(target.args.args) == (1 if owner else 0) and not _stored(target):
            yield INLINE, _inline(node, target), f"{last} in line {node.lineno}"


def _stored(function: _Function) -> bool:
    return any(
        isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        for node in ast.walk(function)
    )


def _inline(call: ast.Expr, target: ast.FunctionDef) -> _Edit:
    def edit(tree: ast.Module) -> None:
        result, body = _same(tree, call), _same(tree, target)
        assert isinstance(body, ast.FunctionDef)
        calls = sum(
            isinstance(item, ast.Attribute | ast.Name)
            and ast.unparse(item).rpartition(".")[2] == target.name
            for item in ast.walk(tree)
        )
        for node in ast.walk(tree):
            for field in ("body", "orelse", "finalbody"):
                block = getattr(node, field, None)
                if isinstance(block, list) and result in block:
                    place = block.index(result)
                    block[place : place + 1] = ast.parse(
                        ast.unparse(ast.Module(body.body, []))
                    ).body
                    if calls == 1:
                        _drop(tree, body)
                    return

    return edit


def _drop(tree: ast.Module, function: ast.FunctionDef) -> None:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and function in body and len(body) > 1:
            body.remove(function)


def _renames(unbroken: Unbroken, tree: ast.Module) -> Iterator[tuple[str, _Edit, str]]:
    """Yield edits that rename a function that is defined and called in this file only."""
    for function in _functions(tree):
        name = function.name
        users = sum(name in text for text in unbroken.files.values())
        if name.startswith("__") or users > 1:
            continue
        if sum(item.name == name for item in _functions(tree)) > 1:
            continue

        def owned(node: ast.Attribute) -> bool:
            return isinstance(node.value, ast.Name)

        def edit(tree: ast.Module, name: str = name) -> None:
            new = f"{name}_renamed"
            for item in ast.walk(tree):
                if isinstance(item, _Function) and item.name == name:
                    item.name = new
                elif isinstance(item, ast.Attribute) and item.attr == name and owned(item):
                    item.attr = new
                elif isinstance(item, ast.Name) and item.id == name:
                    item.id = new

        yield RENAME, edit, name


def _with_dead_code(function: _Function, number: int) -> _Edit:
    ways = (
        "unused = 0",
        "if False:\n    print('never')",
        "def unused(value):\n    return value + 1",
        "for unused in ():\n    print(unused)",
    )

    def edit(tree: ast.Module) -> None:
        result = _same(tree, function)
        assert isinstance(result, _Function)
        result.body[1:1] = ast.parse(ways[number % len(ways)]).body

    return edit
