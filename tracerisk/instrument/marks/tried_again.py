"""From the source: whether a loop retries a failing call until it succeeds."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence

from tracerisk.instrument.source.dotted_names import last_name

_LOOPS = ast.For | ast.AsyncFor | ast.While
_SCOPES = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda | ast.ClassDef
_WITH = ast.With | ast.AsyncWith
_JUMPS = ast.Break | ast.Continue | ast.Return | ast.Raise
_TAKERS = frozenset({"next", "pop", "popleft", "popitem", "get_nowait"})
"""Functions that give something else at each call."""


def is_tried_until_success(tree: ast.Module, call: ast.Call) -> bool:
    """Return whether the success of a call makes up for its failures before.

    That is so in a loop that catches them, if each pass tries the same, or if a pass leaves the
    loop once the call has succeeded.
    """
    return _SuccessPath(_parents(tree), call).makes_up()


def _parents(tree: ast.Module) -> dict[ast.AST, ast.AST]:
    return {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}


class _SuccessPath:
    """The control flow after a successful call, followed outward through what encloses it."""

    def __init__(self, parents: Mapping[ast.AST, ast.AST], call: ast.Call) -> None:
        self._parents = parents
        self._call = call
        self._truth: dict[str, bool] = {}
        """What success assigns, and whether it is then true."""
        self._only_on_success = True
        """Whether this point is reached only after the call has succeeded."""

    def makes_up(self) -> bool:
        node: ast.AST = self._call
        is_caught = is_in_loop = False
        jump: ast.stmt | None = None
        while (parent := self._parents.get(node)) is not None and not isinstance(parent, _SCOPES):
            if isinstance(node, ast.stmt) and jump is None:
                jump = self._jump_from(node, parent)
            if _catches(parent, node):
                is_caught = True
            if isinstance(parent, _LOOPS) and node in parent.body:
                is_left = isinstance(jump, ast.Break | ast.Return)
                if jump is None or isinstance(jump, ast.Continue):
                    is_left = self._ends(parent)
                if is_caught:
                    is_in_loop = True
                    if not is_left and _differs(self._call, parent):
                        return False
                if not isinstance(jump, ast.Return):
                    self._only_on_success &= not is_caught or (
                        is_left and _is_left_by_break(parent)
                    )
                    jump = None
            elif jump is None:
                jump = self._jump_out(node, parent)
            node = parent
        return is_in_loop

    def _jump_from(self, node: ast.stmt, parent: ast.AST) -> ast.stmt | None:
        """Return the jump that the path from a statement meets in its own block, if any."""
        if _has_call_itself(node, self._call):
            if isinstance(node, ast.Return):
                return node
            self._assign(node)
            if isinstance(node, _WITH) and (jump := self._jump_in(node.body)):
                return jump
        for _, block in ast.iter_fields(parent):
            if isinstance(block, list) and node in block:
                later: list[ast.stmt] = block[block.index(node) + 1 :]
                return self._jump_in(later)
        return None

    def _jump_in(self, block: Sequence[ast.stmt]) -> ast.stmt | None:
        """Return the jump that the path through a block meets.

        It is an `ast.Pass` for a jump that is also taken after a failure.
        """
        for statement in block:
            if isinstance(statement, _JUMPS):
                return statement if self._only_on_success else ast.Pass()
            jump: ast.stmt | None = None
            if isinstance(statement, _WITH | ast.Try):
                jump = self._jump_in(statement.body)
            elif isinstance(statement, ast.If):
                jump = self._jump_in_if(statement)
            elif self._only_on_success:
                self._assign(statement)
            if jump is not None:
                return jump
        return None

    def _jump_in_if(self, statement: ast.If) -> ast.stmt | None:
        is_true = self._value(statement.test)
        if is_true is None:
            return None
        taken, other = statement.body, statement.orelse
        if not is_true:
            taken, other = other, taken
        before, self._only_on_success = self._only_on_success, True
        jump = self._jump_in(taken)
        self._only_on_success = before or _jumps(other)
        return jump

    def _jump_out(self, node: ast.AST, parent: ast.AST) -> ast.stmt | None:
        """Return the jump met between the end of a block and the statement after `parent`."""
        if isinstance(parent, ast.Try) and node in parent.body:
            if jump := self._jump_in(parent.orelse):
                return jump
            self._only_on_success &= all(_jumps(handler.body) for handler in parent.handlers)
        elif _catches(parent, node):
            self._only_on_success = False
        return None

    def _assign(self, statement: ast.stmt) -> None:
        for name, value in _assigned(statement):
            self._truth[name] = bool(value.value) if isinstance(value, ast.Constant) else True

    def _value(self, test: ast.expr) -> bool | None:
        """Return what a test gives after success, `None` if that is not known."""
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            value = self._value(test.operand)
            return None if value is None else not value
        if isinstance(test, ast.Compare) and len(test.ops) == 1:
            to = test.comparators[0]
            value = self._truth.get(ast.unparse(test.left))
            if value and isinstance(to, ast.Constant) and to.value is None:
                return isinstance(test.ops[0], ast.IsNot | ast.NotEq)
            return None
        return self._truth.get(ast.unparse(test))

    def _ends(self, loop: ast.AST) -> bool:
        return isinstance(loop, ast.While) and self._value(loop.test) is False


def _has_call_itself(statement: ast.stmt, call: ast.Call) -> bool:
    """Return whether a call is in a statement itself, not in one of its blocks."""
    parts = (part for part in ast.iter_child_nodes(statement) if not isinstance(part, ast.stmt))
    return any(
        inner is call
        for part in parts
        if not isinstance(part, ast.ExceptHandler)
        for inner in ast.walk(part)
    )


def _catches(node: ast.AST, child: ast.AST) -> bool:
    if isinstance(node, ast.Try):
        return bool(node.handlers) and child in node.body
    return (
        isinstance(node, _WITH)
        and child in node.body
        and any(
            isinstance(item.context_expr, ast.Call)
            and last_name(item.context_expr.func) == "suppress"
            for item in node.items
        )
    )


def _jumps(block: Sequence[ast.stmt]) -> bool:
    return bool(block) and isinstance(block[-1], _JUMPS)


def _is_left_by_break(loop: ast.AST) -> bool:
    """Return whether what follows a loop is reached by a `break` alone."""
    if isinstance(loop, ast.While) and isinstance(loop.test, ast.Constant):
        return bool(loop.test.value)
    return isinstance(loop, _LOOPS) and _jumps(loop.orelse)


# What differs from pass to pass


def _differs(call: ast.Call, loop: ast.For | ast.AsyncFor | ast.While) -> bool:
    """Return whether a call in a loop may be another one in each pass."""
    changed: set[str] = set()
    assigned: list[tuple[str, ast.expr]] = []
    own = [loop.target] if not isinstance(loop, ast.While) else []
    for node in (*own, *(inner for part in loop.body for inner in ast.walk(part))):
        if isinstance(node, ast.For | ast.AsyncFor | ast.comprehension | ast.AugAssign):
            changed.update(_names(node.target))
        elif isinstance(node, ast.stmt | ast.NamedExpr):
            assigned += _assigned(node)
    for target in own:
        changed.update(_names(target))
    changed |= {name for name, value in assigned if name in _parts(value)}
    before = -1
    while len(changed) > before:
        before = len(changed)
        changed |= {name for name, value in assigned if _may_change(value, changed)}
    return _may_change(call, changed)


def _may_change(node: ast.expr, changed: set[str]) -> bool:
    takes = any(
        isinstance(inner, ast.Call) and last_name(inner.func) in _TAKERS for inner in ast.walk(node)
    )
    return takes or not changed.isdisjoint(_parts(node))


def _parts(node: ast.expr) -> set[str]:
    kinds = ast.Name | ast.Attribute | ast.Subscript
    return {ast.unparse(inner) for inner in ast.walk(node) if isinstance(inner, kinds)}


def _assigned(statement: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Yield what a statement assigns to which name."""
    targets: list[ast.expr] = []
    if isinstance(statement, ast.Assign):
        targets = statement.targets
    elif isinstance(statement, ast.AnnAssign | ast.NamedExpr):
        targets = [statement.target]
    if isinstance(statement, ast.Assign | ast.AnnAssign | ast.NamedExpr) and statement.value:
        for target in targets:
            for name in _names(target):
                yield name, statement.value
    if isinstance(statement, _WITH):
        for item in statement.items:
            for name in () if item.optional_vars is None else _names(item.optional_vars):
                yield name, item.context_expr


def _names(target: ast.expr) -> Iterator[str]:
    if isinstance(target, ast.Tuple | ast.List):
        for part in target.elts:
            yield from _names(part)
    else:
        yield ast.unparse(target.value if isinstance(target, ast.Starred) else target)
