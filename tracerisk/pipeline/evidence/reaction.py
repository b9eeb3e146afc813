"""How a controller reacted to a failure: its control flow beside that of the run without.

The flow is the sequence of commands, each by its kind, what it addresses and the lines of its call
stack, so that the way in which code is divided into functions plays no role.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from tracerisk.common.evidence.cells import Notice
from tracerisk.instrument.code_positions import call_position
from tracerisk.instrument.commands import Command
from tracerisk.instrument.marks.call_log import Site
from tracerisk.instrument.recording import is_near
from tracerisk.instrument.source.python_source import parsed
from tracerisk.pipeline.evidence.mission_run import MissionRun
from tracerisk.pipeline.run.fault_run import new_reports

AT_ONCE_S = 0.1
"""A controller goes by an answer to which it reacts earlier than this [s]."""
_SECOND_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Reaction:
    """What a controller did in a run with a failure that it does not do without."""

    noticed_s: float | None = None
    """When it showed that it had noticed the failure [s]; `None`: it did not."""
    noticed_by: Notice | None = None
    """By what it noticed it."""
    is_other_way: bool = False
    """Whether its commands differ from those of the run without the failure."""
    went_on: bool = False
    """Whether it went on with its mission after it had noticed, as if nothing were."""
    next_s: float | None = None
    """When it issued its next command after it had noticed [s]; `None` where it issued none."""
    rest_s: float = math.inf
    """When the last command ended that it issued [s]; infinite where one never did."""


@dataclass(frozen=True, slots=True)
class _Step:
    """A command on its way."""

    command: Command
    """The command."""
    lines: tuple[Site, ...]
    """The line and column of each call on its stack, outermost first."""

    @property
    def ns(self) -> int:
        """When it was issued [ns]."""
        return self.command.issue_ns

    def is_as(self, other: _Step) -> bool:
        """Return whether it is the same command of the control flow.

        One that was refused addresses nothing, whatever it was to move, and has another kind: the
        lines of its stack say which it is.
        """
        mine, theirs = self.command, other.command
        is_refused = not (mine.elements and theirs.elements)
        is_alike = mine.kind == theirs.kind and mine.elements == theirs.elements
        return self.lines == other.lines and (is_refused or is_alike)


@dataclass(frozen=True, slots=True)
class _Departure:
    """Where the flow of one root left that of the run without the failure."""

    before_ns: int
    """When the last command was issued that is as in the run without [ns]."""
    ns: int
    """When the first other command was issued, or the run ended [ns]."""


@dataclass(frozen=True, slots=True)
class _Walk:
    """The commands of one root beside those of the run without the failure."""

    departures: tuple[_Departure, ...]
    """Where they differ, in order of time."""
    continued_ns: tuple[int, ...]
    """When commands were issued that took the mission on, as in the run without [ns]."""
    is_complete: bool
    """Whether the last of them is the last of the run without."""


def reaction_to(nominal: MissionRun, failed: MissionRun, fault_s: float) -> Reaction:
    """Return how the controller reacted to a failure at `fault_s` [s] in its run."""
    fault_ns = round(fault_s * _SECOND_NS)
    end_ns = round((failed.trace.end.simulated_s or 0.0) * _SECOND_NS)
    before, after = _by_root(nominal.commands), _by_root(failed.commands)
    walks = [
        _walk(
            before.get(root, ()),
            after.get(root, ()),
            fault_ns,
            end_ns if failed.has_ended else None,
        )
        for root in dict.fromkeys((*before, *after))
    ]
    is_complete = all(walk.is_complete for walk in walks)
    departures = sorted(
        (departure for walk in walks for departure in walk.departures), key=lambda item: item.ns
    )
    if not departures and _ends_with_failure(nominal, failed):
        last_ns = max((command.issue_ns for command in failed.commands), default=0)
        departures = [_Departure(last_ns, end_ns)]
    signs = _Signs(nominal, failed, fault_ns)
    noticed = signs.notice(departures)
    is_other_way = any(walk.departures for walk in walks)
    if noticed is None:
        return Reaction(is_other_way=is_other_way)
    noticed_ns, noticed_by = noticed
    continued = [ns for walk in walks for ns in walk.continued_ns if ns > noticed_ns]
    left_ns = next((item.ns for item in departures if item.ns >= noticed_ns), math.inf)
    nexts = [command for command in failed.commands if command.issue_ns >= noticed_ns]
    return Reaction(
        noticed_ns / _SECOND_NS,
        noticed_by,
        is_other_way,
        # Straight on, or back on its way to the end of the mission.
        any(ns < left_ns for ns in continued) or (bool(continued) and is_complete),
        nexts[0].issue_ns / _SECOND_NS if nexts else None,
        max(
            (math.inf if c.end_ns is None else c.end_ns / _SECOND_NS for c in failed.commands),
            default=0.0,
        ),
    )


def _ends_with_failure(nominal: MissionRun, failed: MissionRun) -> bool:
    """Return whether the controller ended its run by itself, but with a code or an exception."""
    now, before = failed.trace.end.cause, nominal.trace.end.cause
    return failed.has_ended and now != "ended" and now != before


def _by_root(commands: Sequence[Command]) -> Mapping[tuple[object, ...], list[_Step]]:
    """Return the commands by what runs them: the main program, a thread, a callback.

    Of a stream, in which each only replaces the one before it from the same line, the last counts.
    """
    roots: dict[tuple[object, ...], list[_Step]] = {}
    for command in commands:
        outer = command.stack[0]
        own = roots.setdefault((outer.root, outer.function.file, outer.line), [])
        step = _Step(command, tuple(frame.site for frame in command.stack))
        last = own[-1] if own else None
        if (
            last is not None
            and step.is_as(last)
            and last.command.end == "replaced"
            and last.command.replaced_by == command.id
        ):
            own.pop()
        own.append(step)
    return roots


def _walk(
    before: Sequence[_Step], after: Sequence[_Step], fault_ns: int, end_ns: int | None
) -> _Walk:
    """Follow the commands of a root beside those of the run without the failure.

    `end_ns` is when the controller ended its run [ns]; `None` where it did not: one that waits for
    ever misses its last commands unawares.
    """
    place = most = 0
    last_ns = 0
    departures: list[_Departure] = []
    continued: list[int] = []
    is_on_way = True
    for step in after:
        # A failure moves goals too; whether who left the way is back on it, its goal says.
        is_next = is_on_way and place < len(before) and step.is_as(before[place])
        if not is_next:
            if step.ns >= fault_ns:
                departures.append(_Departure(last_ns, step.ns))
            found = _place_of(step, before, place)
            is_on_way = found is not None
            place = place if found is None else found
        if is_on_way:
            place += 1
            last_ns = step.ns
            if place > most:
                most = place
                continued.append(step.ns)
    is_complete = is_on_way and place == len(before)
    if place < len(before) and end_ns is not None and end_ns >= fault_ns:
        departures.append(_Departure(last_ns, end_ns))
    return _Walk(tuple(departures), tuple(continued), is_complete)


def _place_of(step: _Step, before: Sequence[_Step], place: int) -> int | None:
    """Return which command of the run without the failure another one repeats or goes on with."""
    later, earlier = range(place, len(before)), range(place - 1, -1, -1)
    return next(
        (
            at
            for at in (*later, *earlier)
            if step.is_as(before[at]) and is_near(before[at].command.goal, step.command.goal)
        ),
        None,
    )


class _Signs:
    """What of a run with a failure shows that the controller noticed it, beside the run without."""

    def __init__(self, nominal: MissionRun, failed: MissionRun, fault_ns: int) -> None:
        before, now = nominal.calls, failed.calls
        self._failed = failed
        polled = {
            (file, site)
            for file, source in failed.recording.sources.items()
            for site in _polled_sites(source)
        }
        # A loop that waits longer is no other way.
        known = before.executed | polled
        self._new_ns = sorted(
            ns for place, ns in now.first_ns.items() if place not in known and ns >= fault_ns
        )
        handlers = {(item.file, item.line) for item in before.handled}
        self._handled = [
            item
            for item in now.handled
            if (item.file, item.line) not in handlers and item.first_ns >= fault_ns
        ]
        lines = {sign.name for sign in nominal.recording.signs if sign.by == "log"}
        signs = [sign for sign in failed.recording.signs if sign.ns >= fault_ns]
        reports = new_reports(nominal.trace, failed.trace, fault_ns / _SECOND_NS)
        self._log_ns = [sign.ns for sign in signs if sign.by == "log" and sign.name not in lines]
        self._answers = [(sign.ns, sign.by) for sign in signs if sign.by != "log"]
        self._codes = [round((finding.time_s or 0.0) * _SECOND_NS) for finding in reports]

    def notice(self, departures: Sequence[_Departure]) -> tuple[int, Notice] | None:
        """Return when the controller noticed the failure first [ns], and by what."""
        shown = [*self._log_ns, *(item.first_ns for item in self._handled)]
        if departures:
            # What it does first in another way leads to its next command, or to its end.
            first = departures[0]
            shown += [first.ns, *(ns for ns in self._new_ns if first.before_ns <= ns <= first.ns)]
        if not shown:
            return None
        noticed_ns = min(shown)
        return noticed_ns, self._by(noticed_ns, has_departed=bool(departures))

    def _by(self, noticed_ns: int, *, has_departed: bool) -> Notice:
        def is_now(ns: int) -> bool:
            return 0 <= noticed_ns - ns < AT_ONCE_S * _SECOND_NS

        if any(is_now(item.first_ns) and not item.is_own for item in self._handled):
            return "exception"
        answers = [kind for ns, kind in self._answers if is_now(ns)]
        if "result" in answers:
            return "result"
        if answers or any(map(is_now, self._codes)):
            return "code"
        end = self._failed.trace.end
        at_end = is_now(round((end.simulated_s or 0.0) * _SECOND_NS))
        if end.cause == "raised" and at_end and not self._is_raised_here():
            return "exception"
        return "log" if noticed_ns in self._log_ns and not has_departed else "control_flow"

    def _is_raised_here(self) -> bool:
        """Return whether the line at which the run ended raises the exception itself."""
        place = self._failed.trace.end.location
        if place is None or place.line is None:
            return False
        source = self._failed.recording.sources.get(place.file)
        return source is not None and place.line in _raising_lines(source)


@lru_cache(maxsize=16)
def _raising_lines(source: bytes) -> frozenset[int]:
    tree = parsed(source)
    nodes = () if tree is None else ast.walk(tree)
    return frozenset(
        line
        for node in nodes
        if isinstance(node, ast.Raise | ast.Assert)
        for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    )


@lru_cache(maxsize=64)
def _polled_sites(source: bytes) -> frozenset[Site]:
    """Return the calls that a `while` loop makes in each of its rounds."""
    tree = parsed(source)
    loops = [] if tree is None else [n for n in ast.walk(tree) if isinstance(n, ast.While)]
    sites = set()
    for loop in loops:
        pending: list[ast.AST] = [*loop.body]
        while pending:
            node = pending.pop()
            if isinstance(node, ast.Call):
                line, column = call_position(node)
                sites.add((line, column + 1))
            if isinstance(node, ast.If):
                pending.append(node.test)
            elif not isinstance(node, ast.ExceptHandler | ast.Match | ast.FunctionDef):
                pending += ast.iter_child_nodes(node)
    return frozenset(sites)
