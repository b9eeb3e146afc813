"""Which functions of a compiled controller can command hardware, and did in its run."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from tracerisk.adder.sources.c_source import SCOPE, CSource, parse_c
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.verdict import Coverage, Uncovered
from tracerisk.instrument.source.language import is_c

if TYPE_CHECKING:
    from tree_sitter import Node

    from tracerisk.instrument.recording import Recording

_COMMANDS = frozenset(
    {"sendGoal", "sendGoalAndWait", "sendGoalsAndWait", "async_send_goal"}
    | {"move", "asyncMove", "execute", "asyncExecute", "pick", "place"}
)
"""Last names of calls that command motion: those of action clients and of MoveGroupInterface."""
_COMMON = frozenset({"publish", "call", "async_send_request"})
"""Names so common that only calls of the same object count as the same."""


@dataclass(slots=True)
class _Known:
    """A function, and what it calls."""

    line: int
    """The line on which it begins."""
    called: set[str] = field(default_factory=set)
    """The last name of each call, and how it is written where that name is common."""


def c_coverage(recording: Recording) -> Coverage:
    """Return which functions of the sources that the run has shown can command, and which did.

    A call commands as those do that the run has seen to command, or by its name. The probe of a
    compiled node sees functions while they command: one that ran and commanded nothing counts as
    one that never ran.
    """
    known: dict[FunctionRef, _Known] = {}
    sites: dict[str, set[int]] = defaultdict(set)
    for command in recording.commands:
        innermost = command.stack[-1]
        sites[innermost.function.file].add(innermost.site[0])
    commanding = set(_COMMANDS)
    for file, content in sorted(recording.sources.items()):
        if not is_c(file):
            continue
        source = parse_c(content, file)
        for function in source.functions:
            known.setdefault(FunctionRef(file, function.name), _Known(function.line))
        for call, line, is_outermost in _calls(source):
            holder = source.innermost(call.start_byte)
            name = _name(call, source.source)
            if holder is not None and name:
                known[FunctionRef(file, holder.name)].called.add(name)
            if is_outermost and line in sites[file] and name:
                commanding.add(name)
    short = defaultdict(set)
    for ref in known:
        short[ref.name.rpartition(SCOPE)[2]].add(ref)
    # What an own function's name stands for is that function.
    able = _reaching(known, commanding - short.keys())
    ran = {frame.function for command in recording.commands for frame in command.stack}
    able |= ran & known.keys()
    never = sorted(able - ran, key=lambda ref: (ref.file, known[ref].line, ref.name))
    missed = tuple(Uncovered(ref, known[ref].line, is_spare=False) for ref in never)
    return Coverage(len(able) - len(missed), len(able), missed)


def _reaching(known: dict[FunctionRef, _Known], names: Collection[str]) -> set[FunctionRef]:
    """Return the functions from which a call of one of the names can be reached."""
    able: set[FunctionRef] = set()
    reached = set(names)
    while True:
        new = {
            ref
            for ref, function in known.items()
            if ref not in able and not reached.isdisjoint(function.called)
        }
        if not new:
            return able
        able |= new
        reached |= {ref.name.rpartition(SCOPE)[2] for ref in new}


def _calls(source: CSource) -> Iterator[tuple[Node, int, bool]]:
    """Yield each call with the line of its name, and whether it is within no other call."""
    waiting: list[tuple[Node, bool]] = [(source.tree.root_node, True)]
    while waiting:
        node, is_outermost = waiting.pop()
        is_call = node.type == "call_expression"
        if is_call:
            called = node.child_by_field_name("function") or node
            yield node, called.end_point.row + 1, is_outermost
        inner = is_outermost and not is_call
        # A lambda that is an argument is a body of its own.
        inner = inner or node.type == "lambda_expression"
        waiting += [(child, inner) for child in reversed(node.named_children)]


def _name(call: Node, source: bytes) -> str:
    called = call.child_by_field_name("function")
    if called is None:
        return ""
    text = source[called.start_byte : called.end_byte].decode("utf-8", "replace")
    written = "".join(text.partition("<")[0].split())
    last = written.replace("->", ".").replace(SCOPE, ".").rpartition(".")[2]
    return written if last in _COMMON else last
