"""Separate functions that are steps of the task from helpers.

Only the stacks of the commands that ran are looked at. Over these stacks

- a *call* is a function directly below another on a stack; calls within a strongly connected
  component (recursion, states that call each other in a ring) do not count, for either side;
- an *element* of a function is a command site in it (a line and column from which it issued a
  command itself), or a function that it called; a function counts once, however often called;
- the *callers* of a function are the functions that called it. One that called it only while it
  ran as a done-callback does not count where there is another caller;
- a function is a *root* if it stood first on a stack: module-level code, a callback, a timer, a
  thread that inherited nothing;
- a function is a *primitive* if its only element is one command site;
- a function is a *composite* if two or more of its elements are functions, helpers or not.

A function is a helper if

(a) it has two or more callers, or one or more and all are helpers; unless it is a composite or
    a root; or
(b) it is a primitive with one caller, and among the caller's elements other than it the command
    sites and helpers outnumber the rest; or
(c) it is a primitive with one caller, which has no other element and was called from two or
    more sites (function, line and column).

Helpers only ever make more helpers, so applying the rules until nothing changes gives the one
smallest solution, in whatever order they are applied.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.strong_components import strong_components
from tracerisk.errors import InputError
from tracerisk.instrument.marks.call_log import Site
from tracerisk.instrument.tracer import Frame


@dataclass(frozen=True, slots=True)
class HelperRule:
    """Which functions of a run are steps of the task and which are helpers."""

    helpers: frozenset[FunctionRef]
    """All helpers, by the rules or by the user's choice."""
    states: frozenset[FunctionRef] = frozenset()
    """The functions that a user named as steps; they own what is issued below them."""
    enters_states: bool = False
    """Whether a state machine or behaviour tree entered more than one state."""
    named_helpers: frozenset[FunctionRef] = frozenset()
    """The helpers that a user named."""

    def owner_position(self, stack: Sequence[Frame]) -> int:
        """Return where on a command's stack its owner stands.

        The owner is the deepest function above the first helper, counted from the root; where
        the root itself is a helper, the root. A function that a user named as a state owns
        what is issued below it, even where a helper called it. A state of a state machine owns
        all that is issued in it.
        """
        start = max(
            (place for place, frame in enumerate(stack) if frame.function in self.states),
            default=0,
        )
        if self.enters_states:
            for place in range(len(stack) - 1, start - 1, -1):
                frame = stack[place]
                if frame.instance is not None and frame.function not in self.named_helpers:
                    return place
        for place in range(start, len(stack)):
            if stack[place].function in self.helpers:
                return max(place - 1, start)
        return len(stack) - 1


def helper_rule(
    stacks: Iterable[Sequence[Frame]],
    *,
    states: Collection[str] = (),
    helpers: Collection[str] = (),
    beside: Iterable[Sequence[Frame]] = (),
) -> HelperRule:
    """Apply the rules to the stacks of a run's commands.

    `states` and `helpers` are qualified names that a user decided; a name holds in every file.
    `beside` are the stacks of another run, in which its functions are decided by these rules
    alone; of the others, the calls of both runs decide.

    Raises:
        InputError: a name is in both.
    """
    both = sorted(set(states) & set(helpers))
    if both:
        raise InputError(
            f"{', '.join(both)}: named in both `states` and `helpers`; keep the name in one"
        )
    beside = list(beside)
    decided = HelperRule(frozenset())
    if beside:
        decided = helper_rule(beside, states=states, helpers=helpers)
    stacks = [*stacks, *beside]
    entered = {
        (frame.function, frame.instance)
        for stack in (beside or stacks)
        for frame in stack
        if frame.instance is not None
    }
    calls = _Calls.of({call_path(stack) for stack in stacks})
    named_states = frozenset(f for f in calls.functions if f.name in states)
    named_helpers = frozenset(f for f in calls.functions if f.name in helpers)
    found_helpers = {*named_helpers, *decided.helpers}
    known = {frame.function for stack in beside for frame in stack}
    undecided = sorted(calls.functions - found_helpers - named_states - known)
    while True:
        more = {f for f in undecided if calls.is_helper(f, found_helpers)}
        if not more:
            return HelperRule(
                frozenset(found_helpers), named_states, len(entered) > 1, named_helpers
            )
        found_helpers |= more
        undecided = [f for f in undecided if f not in more]


CallPath = tuple[tuple[FunctionRef, Site, str | None], ...]


def call_path(stack: Sequence[Frame]) -> CallPath:
    """Return what the rules look at; equal for the many commands of a loop."""
    return tuple((frame.function, frame.site, frame.root) for frame in stack)


@dataclass(slots=True)
class _Calls:
    """The calls that led to commands, without those within a strongly connected component."""

    functions: set[FunctionRef] = field(default_factory=set)
    """All functions that stood on a stack."""
    roots: set[FunctionRef] = field(default_factory=set)
    """The functions that stood first on a stack or that no controller code called."""
    command_sites: dict[FunctionRef, set[Site]] = field(default_factory=dict)
    """The places from which a function issued commands itself, by function."""
    callees: dict[FunctionRef, set[FunctionRef]] = field(default_factory=dict)
    """The functions that a function called, by caller."""
    callers: dict[FunctionRef, set[FunctionRef]] = field(default_factory=dict)
    """The functions that called a function, by callee, without done-callbacks."""
    done_callers: dict[FunctionRef, set[FunctionRef]] = field(default_factory=dict)
    """The functions that called a function from a done-callback, by callee."""
    call_sites: dict[FunctionRef, set[tuple[FunctionRef, Site]]] = field(default_factory=dict)
    """The callers of a function with the place of the call, by callee."""

    @classmethod
    def of(cls, paths: set[CallPath]) -> _Calls:
        calls = cls()
        edges: dict[FunctionRef, set[FunctionRef]] = {}
        for path in paths:
            for function, _, root in path:
                edges.setdefault(function, set())
                if root is not None:
                    calls.roots.add(function)
            for (caller, _, _), (callee, _, _) in itertools.pairwise(path):
                edges[caller].add(callee)
        component = {
            function: number
            for number, function_refs in enumerate(strong_components(edges))
            for function in function_refs
        }
        for path in paths:
            calls._add(path, component)
        calls.functions = set(edges)
        return calls

    def _add(self, path: CallPath, component: dict[FunctionRef, int]) -> None:
        last, site, _ = path[-1]
        self.command_sites.setdefault(last, set()).add(site)
        for (caller, site, root), (callee, _, _) in itertools.pairwise(path):
            if component[caller] == component[callee]:
                continue
            self.callees.setdefault(caller, set()).add(callee)
            self.call_sites.setdefault(callee, set()).add((caller, site))
            callers = self.done_callers if root == "done_callback" else self.callers
            callers.setdefault(callee, set()).add(caller)

    def counted_callers(self, function: FunctionRef) -> set[FunctionRef]:
        return self.callers.get(function) or self.done_callers.get(function, set())

    def is_primitive(self, function: FunctionRef) -> bool:
        return len(self.command_sites.get(function, ())) == 1 and not self.callees.get(function)

    def is_helper(self, function: FunctionRef, helpers: set[FunctionRef]) -> bool:
        callers = self.counted_callers(function)
        if not callers:
            return False
        is_exempt = function in self.roots or len(self.callees.get(function, ())) >= 2
        if not is_exempt and (len(callers) >= 2 or callers <= helpers):
            return True
        if len(callers) >= 2 or not self.is_primitive(function):
            return False
        (caller,) = callers
        others = self.callees[caller] - {function}
        own = len(self.command_sites.get(caller, ())) + len(others & helpers)
        if own > len(others - helpers):
            return True
        does_nothing_else = not others and not self.command_sites.get(caller)
        return does_nothing_else and len(self.call_sites.get(caller, ())) >= 2
