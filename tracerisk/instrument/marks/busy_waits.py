"""Mark where the turns of `while` loops begin: they take time, though they call nothing.

`while not self.received: pass` waits for a callback. Virtual time stands still while a thread of
the controller runs, so that without a mark nothing would ever be received.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

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


def mark_turns(tree: ast.Module, module: str) -> None:
    """Insert the mark, imported from `module`, at the beginning of each turn of each `while`."""
    used: dict[str, str] = {}
    for loop in list(_loops(tree)):
        name, mark = ("waited", WAITED) if only_looks(loop.body) else ("turned", TURNED)
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


def only_looks(body: Iterable[ast.stmt]) -> bool:
    """Return whether a loop with this body changes nothing: only others can end it."""
    return all(map(_only_looks, body))


def _only_looks(node: ast.stmt) -> bool:
    if isinstance(node, ast.If | ast.While):
        return only_looks(node.body) and only_looks(node.orelse)
    if isinstance(node, ast.Expr):
        value = node.value
        is_said = isinstance(value, ast.Call) and last_name(value.func) in _SAYS
        return is_said or isinstance(value, ast.Constant)
    return isinstance(node, ast.Pass | ast.Continue | ast.Break | ast.Return | ast.Raise)
