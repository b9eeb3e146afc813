"""Changes of calls and of what they return: dropped, doubled, swapped, not waited for."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import libcst as cst

from tracerisk.pipeline.mutation.change import Draft, brief
from tracerisk.pipeline.mutation.changed_numbers import exchanged
from tracerisk.pipeline.mutation.source_tree import Walk, call_of, last_name

_WAITS = frozenset(
    {
        *("sleep", "sleep_for", "sleep_until", "spin_until_future_complete", "spin_once"),
        *("result", "get_result", "join"),
    }
)
_WAIT_OPTIONS = frozenset({"wait", "blocking", "block"})
# A controller without these is none; whoever writes one sees that at once.
_SET_UP = frozenset(
    {
        *("init", "init_node", "roscpp_initialize", "roscpp_shutdown", "shutdown", "try_shutdown"),
        *("destroy_node", "signal_shutdown", "__init__", "main", "exit", "basicConfig"),
    }
)


def is_wait(call: cst.Call) -> bool:
    """Return whether a call does nothing but wait."""
    name = last_name(call.func)
    return name in _WAITS or name.startswith("wait")


def _changed_call(statement: cst.CSTNode) -> cst.Call | None:
    """Return the call of a statement that may be left out; `None` for another one."""
    call = call_of(statement)
    return None if call is None or last_name(call.func) in _SET_UP else call


def call_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes of a call whose result nobody takes: dropped, doubled, not waited for."""
    call = _changed_call(node)
    if call is None:
        return
    code = walk.tree.code(node)
    if is_wait(call):
        yield walk.tree.replaced(node, "pass", "wait-dropped", f"{brief(code)} is left out")
        return
    yield walk.tree.replaced(node, "pass", "call-dropped", f"{brief(code)} is left out")
    words = f"{brief(code)} is called twice"
    yield walk.tree.replaced(node, f"{code}; {code}", "call-doubled", words)


def swapped_calls(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes of the order of two calls that follow each other."""
    if not isinstance(node, cst.IndentedBlock | cst.Module):
        return
    for one, other in pairwise(node.body):
        are_calls = _changed_call(one) is not None and _changed_call(other) is not None
        if are_calls and walk.tree.code(one) != walk.tree.code(other):
            yield exchanged(one, other, "calls-swapped", walk)


def wait_option_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes of `wait=True`: nobody waits."""
    if isinstance(node, cst.Arg) and is_wait_option(node) and walk.tree.code(node.value) == "True":
        words = f"{brief(walk.tree.code(node))} becomes False"
        yield walk.tree.replaced(node.value, "False", "wait-dropped", words)


def is_wait_option(node: cst.Arg) -> bool:
    """Return whether an argument says whether a call waits."""
    return node.keyword is not None and node.keyword.value in _WAIT_OPTIONS


def result_changes(node: cst.CSTNode, walk: Walk) -> Iterator[Draft]:
    """Yield the changes by which a result is not looked at: a check, or the result of a call."""
    tree = walk.tree
    if isinstance(node, cst.If) and node.orelse is None and _leaves(node.body, walk):
        code = tree.code(node.test)
        new = f"({code}) and False" if "(" in code else "False"
        words = f"the check 'if {brief(code)}' is ignored"
        yield tree.replaced(node.test, new, "result-dropped", words)
    elif isinstance(node, cst.Return) and isinstance(node.value, cst.Call | cst.Await):
        code = tree.whole(node.value)
        words = f"the result of {brief(code)} is not returned"
        yield tree.replaced(node, code, "result-dropped", words)


def _leaves(body: cst.BaseSuite, walk: Walk) -> bool:
    """Return whether a block ends what goes on: by `return`, `raise`, `break` or an exit."""
    last = body.body[-1]
    if isinstance(last, cst.SimpleStatementLine):
        last = last.body[-1]
    if isinstance(last, cst.Return | cst.Raise | cst.Break | cst.Continue):
        return True
    return isinstance(last, cst.Expr) and "exit(" in walk.tree.code(last)
