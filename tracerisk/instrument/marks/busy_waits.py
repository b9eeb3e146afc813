"""Mark where the turns of `while` loops begin: they take time, though they call nothing.

`while not self.received: pass` waits for a callback. Virtual time stands still while a thread of
the controller runs, so that without a mark nothing would ever be received.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from typing import TypeAlias

from tracerisk.instrument.marks.calls import is_compiled
from tracerisk.instrument.marks.endless_loops import begin_with_call, import_into
from tracerisk.instrument.source.dotted_names import last_name

TURNED = "__tracerisk_turned__"
"""The name of the mark of a loop that works, in instrumented code."""
WAITED = "__tracerisk_waited__"
"""The name of the mark of a loop that only looks."""

_SAYS = frozenset(
    {"print", "debug", "info", "warn", "warning", "logdebug", "loginfo", "logwarn", "logerr"}
    | {"logdebug_throttle", "loginfo_throttle", "logwarn_throttle", "logerr_throttle"}
)
_TELLS = frozenset(
    {"abs", "all", "any", "bool", "float", "format", "hasattr", "getattr", "int", "isinstance"}
    | {"is_alive", "is_set", "is_shutdown", "len", "max", "min", "ok", "round", "str", "sum"}
    | {"done", "empty", "get_num_connections", "get_state", "is_connected", "is_moving", "locked"}
    | {"get_subscription_count", "get_time", "monotonic", "now", "perf_counter", "time"}
    | {"server_is_ready", "service_is_ready", "wait_for_server", "wait_for_service"}
)
"""Calls that return what is so, and change nothing."""

_Function = ast.FunctionDef | ast.AsyncFunctionDef
_WORKS = (ast.NamedExpr, ast.Yield, ast.YieldFrom, ast.Await)
_STILL = (
    *(ast.Pass, ast.Continue, ast.Break),
    *(ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.cmpop),
)
_LOOPS = (ast.While, ast.For, ast.AsyncFor, ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_LEAVE_LOOP = (ast.Return, ast.Raise, ast.Break)
_LEAVE_ALL = (ast.Return, ast.Raise)

Leaving: TypeAlias = "tuple[type[ast.stmt], ...]"


def mark_turns(tree: ast.Module, module: str) -> None:
    """Insert the mark, imported from `module`, at the beginning of each turn of each `while`."""
    loops = list(_loops(tree))
    if not loops:
        return
    looks = Looks(tree)
    used: dict[str, str] = {}
    for loop in loops:
        name, mark = ("waited", WAITED) if looks.at(loop) else ("turned", TURNED)
        used[name] = mark
        begin_with_call(loop.body, mark)
    import_into(tree, module, used)


def _loops(tree: ast.AST) -> Iterator[ast.While]:
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.While):
            yield node
        pending += [child for child in ast.iter_child_nodes(node) if not is_compiled(child)]


class Looks:
    """Finds which loops of a module change nothing by their turns.

    A call of one of its own functions does what that function does, as if it stood there. What
    is done as a loop is left is done once.
    """

    def __init__(self, tree: ast.Module) -> None:
        self._own: dict[str, list[_Function]] = {}
        for node in ast.walk(tree):
            if isinstance(node, _Function):
                self._own.setdefault(node.name, []).append(node)
        self._known: dict[str, bool] = {}
        self._asked: list[str] = []
        self._n_assumed = 0

    def at(self, loop: ast.While) -> bool:
        """Return whether a loop only looks: only others can end it."""
        return self._looks(loop.test) and self._all(loop.body, _LEAVE_LOOP)

    def _all(self, body: Sequence[ast.stmt], leaving: Leaving) -> bool:
        is_left = bool(body) and isinstance(body[-1], leaving) and not _comes_round(body)
        return is_left or all(self._statement(node, leaving) for node in body)

    def _statement(self, node: ast.stmt, leaving: Leaving) -> bool:
        if isinstance(node, ast.If | ast.While):
            is_loop = isinstance(node, ast.While)
            leaves = tuple(kind for kind in leaving if not is_loop or kind in _LEAVE_ALL)
            bodies = (node.body, node.orelse)
            return self._looks(node.test) and all(self._all(body, leaves) for body in bodies)
        if isinstance(node, ast.Return | ast.Raise | ast.Expr):
            return self._looks(node)
        return isinstance(node, _STILL)

    def _looks(self, node: ast.AST) -> bool:
        if isinstance(node, _WORKS):
            return False
        if isinstance(node, ast.Call) and not self._tells(last_name(node.func)):
            return False
        is_known = isinstance(node, ast.expr | ast.Return | ast.Raise | ast.Expr | ast.keyword)
        return (
            all(map(self._looks, ast.iter_child_nodes(node)))
            if is_known
            else isinstance(node, _STILL)
        )

    def _tells(self, name: str | None) -> bool:
        """Return whether a call of a name changes nothing."""
        if name not in self._own:
            return name in _SAYS or name in _TELLS
        if name in self._known:
            return self._known[name]
        if name in self._asked:
            # Where one calls itself, its other statements decide.
            self._n_assumed += 1
            return True
        self._asked.append(name)
        n_assumed = self._n_assumed
        tells = all(self._all(function.body, ()) for function in self._own[name])
        self._asked.pop()
        # Else it may rest on what is still being asked.
        if not tells or not self._asked or self._n_assumed == n_assumed:
            self._known[name] = tells
        return tells


def _comes_round(body: Sequence[ast.AST]) -> bool:
    """Return whether a `continue` of the loop itself is in its code."""
    return any(
        isinstance(node, ast.Continue)
        or (not isinstance(node, _LOOPS) and _comes_round(tuple(ast.iter_child_nodes(node))))
        for node in body
    )
