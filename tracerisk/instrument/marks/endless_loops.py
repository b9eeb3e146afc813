"""Find the loops that have no end of their own, and mark where each iteration begins.

A loop is endless if its condition holds as long as the program may run (`True`,
`not rospy.is_shutdown()`, `rclpy.ok()`) and no `break`, `return` or exit leaves it, not counting
those that only an interruption or a shutdown reaches.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping

from tracerisk.instrument.source.dotted_names import last_name

MARKER = "__tracerisk_looped__"
"""The name of the marker in instrumented code; not mangled in classes, hidden from `*`."""

_EXITS = frozenset(
    {"exit", "quit", "_exit", "abort", "signal_shutdown", "shutdown", "try_shutdown"}
)
_INTERRUPTIONS = frozenset(
    {"KeyboardInterrupt", "ROSInterruptException", "ExternalShutdownException"}
)
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)


def endless_loops(tree: ast.AST) -> Iterator[ast.While]:
    """Yield each `while` that has no end of its own."""
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.While)
            and _holds(node.test)
            and not _leaves(node.body, inner=False)
        ):
            yield node


def mark_endless_loops(tree: ast.Module, module: str, file: str) -> None:
    """Insert a call of the marker, imported from `module`, at the beginning of each iteration.

    It is called with `file` and the loop's line. The inserted nodes have the positions of the
    statement that follows.
    """
    loops = list(endless_loops(tree))
    for loop in loops:
        begin_with_call(loop.body, MARKER, file, loop.lineno)
    import_into(tree, module, {"looped": MARKER} if loops else {})


def begin_with_call(body: list[ast.stmt], name: str, *arguments: str | int) -> None:
    """Insert a call before the first statement of a body, at the position of that."""
    given: list[ast.expr] = [ast.Constant(argument) for argument in arguments]
    call = ast.Expr(ast.Call(ast.Name(name, ast.Load()), given, []))
    for node in ast.walk(call):
        if "lineno" in node._attributes:
            ast.copy_location(node, body[0])
    body.insert(0, call)


def import_into(tree: ast.Module, module: str, names: Mapping[str, str]) -> None:
    """Import what inserted code calls; `names` maps its name in `module` to that in the tree."""
    if not names:
        return
    place = {"lineno": 1, "col_offset": 0, "end_lineno": 1, "end_col_offset": 0}
    aliases = [ast.alias(name, own, **place) for name, own in names.items()]
    tree.body.insert(begin_of_code(tree), ast.ImportFrom(module, aliases, 0, **place))


def begin_of_code(tree: ast.Module) -> int:
    """Return how many statements must stay first: the docstring and `from __future__` imports."""
    index = 1 if ast.get_docstring(tree, clean=False) is not None else 0
    while index < len(tree.body) and _is_future_import(tree.body[index]):
        index += 1
    return index


def _is_future_import(node: ast.stmt) -> bool:
    return isinstance(node, ast.ImportFrom) and node.module == "__future__" and node.level == 0


def _holds(test: ast.expr) -> bool:
    """Return whether a condition holds until the program is shut down."""
    if isinstance(test, ast.Constant):
        return bool(test.value)
    if isinstance(test, ast.BoolOp):
        held = [_holds(value) for value in test.values]
        return any(held) if isinstance(test.op, ast.Or) else all(held)
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        return _is_call_of(test.operand, ("is_shutdown", "is_shutdown_requested"))
    return _is_call_of(test, ("ok",))


def _is_call_of(node: ast.expr, names: Iterable[str]) -> bool:
    return isinstance(node, ast.Call) and last_name(node.func) in names


def _leaves(body: Iterable[ast.AST], *, inner: bool) -> bool:
    """Return whether something in a loop's body leaves the loop; `inner`: within another loop."""
    return any(_leaves_by(node, inner=inner) for node in body)


def _leaves_by(node: ast.AST, *, inner: bool) -> bool:
    if isinstance(node, _FUNCTIONS):
        return False
    if isinstance(node, ast.Return) or (isinstance(node, ast.Break) and not inner):
        return True
    if isinstance(node, ast.Call) and last_name(node.func) in _EXITS:
        return True
    if isinstance(node, ast.ExceptHandler) and _names(node.type) & _INTERRUPTIONS:
        return False
    if isinstance(node, ast.If) and _is_over(node.test):
        return _leaves(node.orelse, inner=inner)
    if isinstance(node, ast.For | ast.AsyncFor | ast.While):
        return _leaves(node.body, inner=True) or _leaves(node.orelse, inner=inner)
    return _leaves(ast.iter_child_nodes(node), inner=inner)


def _is_over(test: ast.expr) -> bool:
    """Return whether a condition holds only when the program is shut down."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        return _is_call_of(test.operand, ("ok",))
    return _is_call_of(test, ("is_shutdown", "is_shutdown_requested"))


def _names(node: ast.expr | None) -> set[str]:
    if isinstance(node, ast.Tuple):
        return {name for elt in node.elts for name in _names(elt)}
    return {last_name(node)}
