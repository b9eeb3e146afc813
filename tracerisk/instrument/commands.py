"""The commands of a run: what issued each, what it addressed, and how it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from tracerisk.errors import Location
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, TracedCommand

_SECOND_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Command:
    """A call that made hardware act, or was refused, from its issue to its end."""

    id: int
    """Its number, from 1 in the order of issue; 0 where it was refused or ignored."""
    kind: str
    """How it was given: `move_group`, `gripper_command`..."""
    elements: tuple[str, ...]
    """The names of the joints and grippers that it addresses."""
    stack: tuple[Frame, ...]
    """The functions that issued it, root first; never empty."""
    issue_ns: int
    """When it was issued, in simulated time [ns]."""
    end_ns: int | None = None
    """When it ended [ns]; `None` where the child died, or nobody knows."""
    end: CommandEnd | None = None
    """How it ended; `None` where the child died, or nobody knows."""
    goal: tuple[float, ...] = ()
    """The positions to which it led in the end, one a joint [rad or m]."""
    way_done: float | None = None
    """The fraction of its way that was done when it ended, by the joint with the farthest to go."""
    replaced_by: int | None = None
    """The id of the command that replaced it; `None` where none did, or one without a stack."""
    after: int = 0
    """The id of the last command issued before it, of one that was refused or ignored."""

    def with_times(self, changed: Callable[[int], int]) -> Command:
        """Return it with each time [ns] mapped by `changed`."""
        end_ns = None if self.end_ns is None else changed(self.end_ns)
        return replace(self, issue_ns=changed(self.issue_ns), end_ns=end_ns)


def in_order(commands: Iterable[Command]) -> list[Command]:
    """Return commands in the order of issue, those that were refused in their place."""
    return sorted(commands, key=lambda item: (item.issue_ns, item.id or item.after, not item.id))


def traced_commands(
    commands: Iterable[Command], refused: Iterable[Command] = ()
) -> tuple[TracedCommand, ...]:
    """Return commands as a trace lists them, with those that were refused, in the order of issue.

    A command of which nobody knows the end was cut by the end of the run.
    """
    ordered = in_order((*commands, *refused))
    place_of = {command.id: place for place, command in enumerate(ordered) if command.id}
    return tuple(_traced(command, place_of) for command in ordered)


def _traced(command: Command, place_of: dict[int, int]) -> TracedCommand:
    innermost = command.stack[-1]
    return TracedCommand(
        function=innermost.function,
        line=innermost.site[0],
        kind=command.kind,
        elements=command.elements,
        issue_s=command.issue_ns / _SECOND_NS,
        end_s=None if command.end_ns is None else command.end_ns / _SECOND_NS,
        end=command.end or "cut_by_end",
        way_done=command.way_done,
        replaced_by=None if command.replaced_by is None else place_of.get(command.replaced_by),
        callers=tuple(
            Location(frame.function.file, frame.site[0]) for frame in command.stack[-2::-1]
        ),
    )
