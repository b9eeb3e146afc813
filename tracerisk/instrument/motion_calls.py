"""Which calls of a controller command motion: known by their names, or seen to do so in the run."""

from __future__ import annotations

import ast
import builtins
import re
from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from tracerisk.common.function_ref import FunctionRef
from tracerisk.instrument.code_positions import call_position
from tracerisk.instrument.marks.call_log import Calls, Place, Site, Turn
from tracerisk.instrument.marks.calls import MarkedCall, marked_calls
from tracerisk.instrument.source.dotted_names import dotted_name, last_name
from tracerisk.instrument.source.hidden_calls import hidden_calls
from tracerisk.instrument.source.python_source import parsed

MOTION_CALLS = frozenset(
    {"go", "execute", "execute_and_wait", "pick", "place"}
    | {"send_goal", "send_goal_async", "send_goal_and_wait"}
)
"""Last names of calls that command motion: those of move groups and of action clients."""

# Names so common that calls count as the same only if the whole expression is the same.
_COMMON = frozenset({"publish", "call", "call_async", "send_request"})


_MOST_SHOWN = 60
_LIKE_COMMANDS = re.compile(
    r"(go|move|jog|servo|grasp|grip|home|pick|place|send|execute|publish|call)(?![a-z])|move[jlcp]$|"
    r"set_(joint|pose|position|ee|gripper|target)|(open|close)_(gripper|hand)"
)


def is_like_command(name: str) -> bool:
    """Return whether a call's name looks like that of a driver function that commands motion."""
    return _LIKE_COMMANDS.match(name.rpartition(".")[2]) is not None


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
        if not isinstance(node, ast.Call):
            continue
        line, column = call_position(node)
        written = dotted_name(node.func)
        # `exec` and `next` command by what they are given.
        if (line, column + 1) in wanted and written and not hasattr(builtins, written):
            names.add(written)
            last = written.rpartition(".")[2]
            if isinstance(node.func, ast.Attribute) and last not in _COMMON:
                names.add(last)
    return frozenset(names)


def motion_names(written: Iterable[str]) -> frozenset[str]:
    """Return the last names of calls that command, with those `written` of a run, but common ones.

    An attribute of a common name may be something else.
    """
    return MOTION_CALLS | {name.rpartition(".")[2] for name in written} - _COMMON


@dataclass(frozen=True, slots=True)
class MissedCall:
    """A call that led to no command, although the same call did at another place."""

    file: str
    """The path of the source from the controller's root."""
    line: int
    """The line of the call, from 1."""
    written: str
    """As it is written: `self.arm.go`."""
    was_executed: bool
    """Whether the run executed it, in vain."""


@dataclass(frozen=True, slots=True)
class Commanding:
    """What of a run led to commands."""

    calls: frozenset[Place]
    """The places of all calls that did, whichever function they are in."""
    functions: frozenset[FunctionRef]
    """The functions that stood on the stack of a command."""


def missed_calls(
    source: bytes, file: str, commanding: Commanding, calls: Calls
) -> tuple[MissedCall, ...]:
    """Return the calls of a file that led to no command although the same call did elsewhere.

    One that was executed is missed if the function it called turned back before it commanded, or
    if nothing has run what it made. One that was not executed is missed unless only an exception
    leads to it, or the same call led to no command where it was executed. So is one of which nobody
    can read what it commands.
    """
    tree = parsed(source)
    if tree is None:
        return ()
    source_calls = [_SourceCall(call, (file, call.site)) for call in marked_calls(tree)]
    own = _commanding_names(tree, file, commanding)
    known = {call.same for call in source_calls if call.place in commanding.calls}
    hidden = set(map(id, hidden_calls(tree, motion_names(written for written, _ in known))))
    in_vain = _turned_back(commanding, calls) | {
        call.place
        for call in source_calls
        if call.place in calls.waiting - commanding.calls
        and (call.same in known or last_name(call.marked.node.func) in own)
    }
    # A call that was executed and moved nothing only asks (for a mode, a state): its name is no
    # evidence of motion.
    asking = {
        call.same
        for call in source_calls
        if call.place in calls.executed - commanding.calls and call.place not in in_vain
    }
    missed = []
    for call in source_calls:
        is_missed = call.place in in_vain
        if call.place not in calls.executed | commanding.calls and not call.marked.is_spare:
            is_missed = (call.same in known or call.is_of(own)) and call.same not in asking
            is_missed |= id(call.marked.node) in hidden
        if is_missed:
            function = call.marked.node.func
            written = call.written or last_name(function) or ast.unparse(function)[:_MOST_SHOWN]
            was_executed = call.place in calls.executed
            missed.append(MissedCall(file, call.marked.node.lineno, written, was_executed))
    return tuple(sorted(missed, key=lambda call: (call.line, call.written)))


@dataclass(frozen=True, slots=True)
class _SourceCall:
    """A call that may issue a command, with its place in the controller's files."""

    marked: MarkedCall
    """The call and the scope that it is in."""
    place: Place
    """The file from the controller's root, with line and column."""

    @property
    def written(self) -> str:
        return dotted_name(self.marked.node.func)

    @property
    def same(self) -> tuple[str, int]:
        """A key that is equal for calls of the same thing."""
        owner, _, last = self.written.rpartition(".")
        # A local `publisher` may be another one in another function.
        is_local = last in _COMMON and owner.partition(".")[0] != "self"
        return self.written, id(self.marked.scope) if is_local else 0

    def is_of(self, names: Collection[str]) -> bool:
        """Return whether it calls one of the functions of its file with these names."""
        owner, _, last = self.written.rpartition(".")
        return owner in ("", "self") and last in names


def _commanding_names(tree: ast.Module, file: str, commanding: Commanding) -> set[str]:
    """Return the names of functions that led to commands and that the file defines exactly once."""
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    defined = Counter(node.name for node in ast.walk(tree) if isinstance(node, functions))
    names = {ref.name.rpartition(".")[2] for ref in commanding.functions if ref.file == file}
    return {name for name in names if defined[name] == 1}


def _turned_back(commanding: Commanding, calls: Calls) -> frozenset[Place]:
    """Return the places of calls whose functions always returned before they commanded."""
    turns: dict[Place, list[Turn]] = {}
    executed: dict[FunctionRef, set[Place]] = {}
    for turn in calls.turns:
        turns.setdefault(turn.place, []).append(turn)
        if turn.executed & commanding.calls:
            executed.setdefault(turn.function, set()).update(turn.executed)

    def turned_back(turn: Turn, within: frozenset[Place]) -> bool:
        """Return whether a function returned before the calls by which it commands elsewhere."""
        if turn.function not in commanding.functions or turn.place in within:
            return False
        inner = turn.executed & commanding.calls
        if not inner:
            # A function that did something else instead had another task, so it did not turn back.
            return turn.executed <= executed.get(turn.function, set())
        deeper = within | {turn.place}
        return all(
            any(turned_back(below, deeper) for below in turns.get(place, ())) for place in inner
        )

    return frozenset(
        place
        for place, item in turns.items()
        if place not in commanding.calls and all(turned_back(turn, frozenset()) for turn in item)
    )
