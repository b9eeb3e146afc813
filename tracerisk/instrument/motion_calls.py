"""Which calls of a controller command motion: known by their names, or seen to do so in the run."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from tracerisk.instrument.tracer import Site
from tracerisk.source.dotted_names import dotted_name
from tracerisk.source.python_source import parsed

MOTION_CALLS = frozenset(
    {"go", "execute", "execute_and_wait", "pick", "place"}
    | {"send_goal", "send_goal_async", "send_goal_and_wait"}
)
"""Last names of calls that command motion: those of move groups and of action clients."""

# What so many things have that only the same expression says the same.
_COMMON = frozenset({"publish", "call", "call_async", "send_request"})


def calls_at(source: bytes, sites: Collection[Site]) -> frozenset[str]:
    """Return the names of the calls at some places of a source, as a call graph names them.

    Each is listed as it is written (`self.pub.publish`), and by its last name too where that is
    not one that other calls have as well. A call of what is not a plain name is left out.
    """
    wanted = set(sites)
    names: set[str] = set()
    tree = parsed(source)
    if tree is None:
        return frozenset()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (node.lineno, node.col_offset + 1) in wanted:
            written = dotted_name(node.func)
            if not written:
                continue
            names.add(written)
            last = written.rpartition(".")[2]
            if isinstance(node.func, ast.Attribute) and last not in _COMMON:
                names.add(last)
    return frozenset(names)


@dataclass(frozen=True, slots=True)
class MissedCall:
    """A call that led to no command, although the same call did at another place."""

    line: int
    written: str
    """As it is written: `self.arm.go`."""


def missed_calls(
    source: bytes, made: Collection[Site], commanding: Collection[str]
) -> tuple[MissedCall, ...]:
    """Return the calls that led to no command although the same call did at another place.

    `made` are the places of the calls of this source that led to commands, `commanding` the last
    names of the controller's functions that did. A call is the same by its whole expression
    (`self.arm.go`); or as one of such a function, by its plain name or on `self`, where the
    source has no other function of that name.
    """
    tree = parsed(source)
    if tree is None:
        return ()
    calls = list(_calls(tree))
    known = {_same(call, scope) for call, scope in calls if _is_made(call, made)}
    functions = [node for node in ast.walk(tree) if isinstance(node, _FUNCTIONS)]
    defined = Counter(node.name for node in functions)
    coroutines = {node.name for node in functions if isinstance(node, ast.AsyncFunctionDef)}
    missed = []
    for call, scope in calls:
        # A coroutine that goes on later is called by its executor: its callers are not on the
        # stack.
        if isinstance(scope, ast.AsyncFunctionDef) or _is_made(call, made):
            continue
        written = dotted_name(call.func)
        if not written:
            continue
        owner, _, last = written.rpartition(".")
        if last in coroutines:
            # The call only makes it; a loop runs it.
            continue
        is_own = owner in ("", "self") and last in commanding and defined[last] == 1
        if _same(call, scope) in known or is_own:
            missed.append(MissedCall(call.lineno, written))
    return tuple(sorted(missed, key=lambda each: (each.line, each.written)))


_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def _calls(
    node: ast.AST, scope: ast.AST | None = None
) -> Iterator[tuple[ast.Call, ast.AST | None]]:
    """Yield the calls below a node, each with the function around it."""
    if isinstance(node, ast.Call):
        yield node, scope
    inner = node if isinstance(node, _FUNCTIONS) else scope
    for each in ast.iter_child_nodes(node):
        yield from _calls(each, inner)


def _same(call: ast.Call, scope: ast.AST | None) -> tuple[str, int]:
    """Return what is equal for calls of the same thing."""
    written = dotted_name(call.func)
    owner, _, last = written.rpartition(".")
    # A local `publisher` may be another one in another function.
    is_local = last in _COMMON and owner.partition(".")[0] != "self"
    return written, id(scope) if is_local else 0


def _is_made(node: ast.Call, made: Collection[Site]) -> bool:
    if (node.lineno, node.col_offset + 1) in made:
        return True
    # Where no column is known, its lines decide.
    last = node.end_lineno or node.lineno
    return any(column == 0 and node.lineno <= line <= last for line, column in made)
