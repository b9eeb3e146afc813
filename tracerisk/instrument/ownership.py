"""Assign each command to a function, and each moment of the run to a visit."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.instance_name import instance_name
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location
from tracerisk.instrument.commands import Command
from tracerisk.instrument.helper_rule import helper_rule
from tracerisk.instrument.recording import Recording
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, TracedFunction, VisitOutcome

_SECOND_NS = 1_000_000_000
_MOST_INSTANCES = 50  # of one function; with more, their names are taken to be generated
_OUTCOME_OF: dict[CommandEnd | None, VisitOutcome] = {
    "arrived": "succeeded",
    "aborted": "aborted",
    "replaced": "preempted",
    "cancelled": "preempted",
}
"""What a visit has come to by the end of its last command; `unfinished` by any other."""


@dataclass(frozen=True, slots=True)
class OwnedVisit:
    """One activation of an owner, or several that followed while a command was still live."""

    function: FunctionRef
    """The owner, named by its instance where several instances of a state exist."""
    line: int
    """The line of the owner's `def`, from 1."""
    start_ns: int
    """The simulated time at which the first command was issued [ns]."""
    commands: tuple[int, ...]
    """The ids of the commands of the visit, in the order of issue."""
    outcome: VisitOutcome
    """How the last command ended; `unfinished` where one of them had not ended with the run."""


@dataclass(frozen=True, slots=True)
class LiveCommand:
    """A command with its visit and the time until which it was live."""

    command: Command
    """The command as it was recorded."""
    visit: int
    """The index of its visit in `Attribution.visits`, from 0."""
    until_ns: tuple[int, ...]
    """The end of the command, or the issue of the later command that superseded it, for each of its
    elements [ns], (n_elements,); a single entry without elements."""

    @property
    def live_until_ns(self) -> int:
        """When the command was live on no element any more [ns]."""
        return max(self.until_ns)


@dataclass(frozen=True, slots=True)
class Attribution:
    """Which function owns which activity of one run."""

    functions: tuple[TracedFunction, ...] = ()
    """The owners, in the order of their first visit."""
    visits: tuple[OwnedVisit, ...] = ()
    """The visits, in the order of their first command."""
    commands: tuple[LiveCommand, ...] = ()
    """The commands, in the order of issue."""
    helpers: frozenset[FunctionRef] = frozenset()
    """The functions that are helpers; they own a command only as a root."""
    findings: tuple[Finding, ...] = ()
    """A `concurrent_owners` for each pair of owners with commands live at the same time."""
    _current: dict[tuple[int, int], NDArray[np.int64]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )
    """The results of `current`, each (n_steps,), by number and length of the steps [ns]."""

    def current(self, n_steps: int, step_ns: int) -> NDArray[np.int64]:
        """Return the run's current visit at each physics step.

        It is that of the latest live command, else of the latest command; before the first
        command, the first visit. A step belongs to what holds at its start.

        Returns:
            (n_steps,) indices into `visits`; all -1 where the run has no visit.
        """
        key = n_steps, step_ns
        known = self._current.get(key)
        if known is None:
            # Asked for again for each element.
            known = self._current[key] = self._current_visits(n_steps, step_ns)
        return np.array(known)

    def _current_visits(self, n_steps: int, step_ns: int) -> NDArray[np.int64]:
        if not self.commands:
            return np.full(n_steps, -1, dtype=np.int64)
        visits = np.array([command.visit for command in self.commands], dtype=np.int64)
        issued = np.array([command.command.issue_ns for command in self.commands], dtype=np.int64)
        starts = np.arange(n_steps, dtype=np.int64) * step_ns
        latest = np.searchsorted(issued, starts, side="right") - 1
        owner: NDArray[np.int64] = visits[np.maximum(latest, 0)]
        for command in self.commands:
            _paint(owner, command, command.live_until_ns, step_ns)
        return owner

    def assign(self, element: str, n_steps: int, step_ns: int) -> NDArray[np.int64]:
        """Return the visit that owns each physics step of one element.

        It is that of the latest live command which addresses the element, else the current one.

        Returns:
            (n_steps,) indices into `visits`; all -1 where the run has no visit.
        """
        owner = self.current(n_steps, step_ns)
        for command in self.commands:
            if element in command.command.elements:
                place = command.command.elements.index(element)
                _paint(owner, command, command.until_ns[place], step_ns)
        return owner


def attribute(
    recording: Recording,
    *,
    states: Collection[str] = (),
    helpers: Collection[str] = (),
    end_ns: int,
    beside: Recording | None = None,
) -> Attribution:
    """Find the owner of each command by the rules of `helper_rule`, and each owner's visits.

    `states` and `helpers` are qualified names that overrule the rules; `end_ns` is the simulated
    time at which the run ended [ns]. `beside` is another run, whose functions and instances are
    distinguished here as they are there: a run that was cut short calls a helper from fewer places,
    one that tries again from more.

    Raises:
        InputError: a name is in both `states` and `helpers`.
    """
    commands = recording.commands
    stacks = [command.stack for command in commands]
    others = [] if beside is None else [command.stack for command in beside.commands]
    rule = helper_rule(stacks, states=states, helpers=helpers, beside=others)
    owners, known = (
        [stack[rule.owner_position(stack)] for stack in of_run] for of_run in (stacks, others)
    )
    owners = _named_by_instance(owners, known)
    visits, visit_of = _visits(commands, owners)
    live = _live(commands, visit_of, end_ns)
    return Attribution(
        _functions(visits), visits, live, rule.helpers, _concurrent_owners(live, visits)
    )


def _paint(owner: NDArray[np.int64], live: LiveCommand, until_ns: int, step_ns: int) -> None:
    start, stop = -(-live.command.issue_ns // step_ns), -(-until_ns // step_ns)
    owner[start:stop] = live.visit


def _live(
    commands: Sequence[Command], visit_of: Sequence[int], end_ns: int
) -> tuple[LiveCommand, ...]:
    next_issue: dict[str, int] = {}
    live: list[LiveCommand] = []
    for command, visit in zip(reversed(commands), reversed(visit_of), strict=True):
        end = end_ns if command.end_ns is None else command.end_ns
        until = tuple(min(end, next_issue.get(element, end)) for element in command.elements)
        live.append(LiveCommand(command, visit, until or (end,)))
        next_issue.update(dict.fromkeys(command.elements, command.issue_ns))
    return tuple(reversed(live))


@dataclass(slots=True)
class _OpenVisit:
    """A visit while the commands are read."""

    index: int
    """Its place in the order of the visits, from 0."""
    function: FunctionRef
    """The owner of the visit."""
    line: int
    """The line of the owner's `def`, from 1."""
    commands: list[Command] = field(default_factory=list)
    """Its commands so far, in the order of issue."""
    live: list[Command] = field(default_factory=list)
    """Those of its commands that may still be live."""

    def closed(self) -> OwnedVisit:
        outcome = _OUTCOME_OF.get(self.commands[-1].end, "unfinished")
        if any(command.end in (None, "cut_by_end") for command in self.commands):
            outcome = "unfinished"
        return OwnedVisit(
            self.function,
            self.line,
            self.commands[0].issue_ns,
            tuple(item.id for item in self.commands),
            outcome,
        )


def _named_by_instance(owners: Sequence[Frame], known: Sequence[Frame]) -> list[Frame]:
    """Add the instance to names of owners that are methods of a state with several instances.

    Of a class among the `known` owners, which are those of another run, they alone count.
    """
    labels: dict[FunctionRef, set[str]] = {}
    methods: dict[tuple[str, str], set[FunctionRef]] = {}
    there = {_class_of(owner) for owner in known}
    for owner in (*known, *(owner for owner in owners if _class_of(owner) not in there)):
        if owner.instance:
            labels.setdefault(owner.function, set()).add(owner.instance)
            methods.setdefault(_class_of(owner), set()).add(owner.function)

    def named(owner: Frame) -> Frame:
        ref = owner.function
        if not owner.instance or not 2 <= len(labels.get(ref, ())) <= _MOST_INSTANCES:
            return owner
        is_only = len(methods[_class_of(owner)]) == 1
        name = instance_name(ref.name, owner.instance, is_only_method=is_only)
        return replace(owner, function=FunctionRef(ref.file, name))

    return list(map(named, owners))


def _class_of(owner: Frame) -> tuple[str, str]:
    return owner.function.file, owner.function.name.rpartition(".")[0]


def _visits(
    commands: Sequence[Command], owners: Sequence[Frame]
) -> tuple[tuple[OwnedVisit, ...], list[int]]:
    """Gather the commands into visits; return these, and the visit of each command."""
    visits: list[_OpenVisit] = []
    by_activation: dict[tuple[FunctionRef, int], _OpenVisit] = {}
    last_of_owner: dict[FunctionRef, _OpenVisit] = {}
    last_on_element: dict[str, int] = {}
    visit_of: list[int] = []
    for command, owner in zip(commands, owners, strict=True):
        key = (owner.function, owner.activation)
        visit = by_activation.get(key)
        if visit is None:
            visit = last_of_owner.get(owner.function)
            if visit is None or not _still_live(visit, command, last_on_element):
                visit = _OpenVisit(len(visits), owner.function, owner.line)
                visits.append(visit)
            by_activation[key] = visit
        last_of_owner[owner.function] = visit
        visit.commands.append(command)
        visit.live.append(command)
        visit_of.append(visit.index)
        last_on_element.update(dict.fromkeys(command.elements, command.id))
    return tuple(open_visit.closed() for open_visit in visits), visit_of


def _still_live(visit: _OpenVisit, command: Command, last_on_element: dict[str, int]) -> bool:
    """Return whether a command of the visit was live until `command` was issued.

    A command that `command` itself supersedes counts as live.
    """

    def is_live(each: Command) -> bool:
        held = [name for name in each.elements if last_on_element[name] == each.id]
        if each.elements and not held:
            return False
        if each.end_ns is None or each.end_ns > command.issue_ns:
            return True
        return (
            each.end_ns == command.issue_ns
            and each.end in ("replaced", "cancelled")
            and not command_elements.isdisjoint(held)
        )

    command_elements = frozenset(command.elements)
    visit.live = [each for each in visit.live if is_live(each)]
    return bool(visit.live)


def _functions(visits: Iterable[OwnedVisit]) -> tuple[TracedFunction, ...]:
    lines: dict[FunctionRef, int] = {}
    for visit in visits:
        lines.setdefault(visit.function, visit.line)
    return tuple(
        TracedFunction(ref, line, rank) for rank, (ref, line) in enumerate(lines.items(), start=1)
    )


def _concurrent_owners(
    live: Sequence[LiveCommand], visits: Sequence[OwnedVisit]
) -> tuple[Finding, ...]:
    """Return each pair of owners that had live commands at the same time, once."""
    findings: list[Finding] = []
    reported: set[frozenset[FunctionRef]] = set()
    open_commands: list[LiveCommand] = []
    for live_command in live:
        now = live_command.command.issue_ns
        open_commands = [other for other in open_commands if other.live_until_ns > now]
        if live_command.live_until_ns <= now:
            continue
        visit = visits[live_command.visit]
        for other in open_commands:
            earlier = visits[other.visit].function
            pair = frozenset({earlier, visit.function})
            if len(pair) == 1 or pair in reported:
                continue
            reported.add(pair)
            message = (
                f"{visit.function.name} commands {', '.join(live_command.command.elements)} "
                "while a "
                f"command of {earlier.name} is still live; an addressed element counts for the "
                "function that addressed it last, every other element for the function of the "
                "latest command"
            )
            location = Location(visit.function.file, visit.line)
            findings.append(Finding("concurrent_owners", message, now / _SECOND_NS, location))
        open_commands.append(live_command)
    return tuple(findings)
