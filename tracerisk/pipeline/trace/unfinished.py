"""Which commands were not carried out to their end although nothing failed, and their retries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from tracerisk.errors import Location
from tracerisk.instrument.recording import is_near
from tracerisk.pipeline.trace.recorded_run import IssuedCommand, RecordedRun

_ARRIVED = 0.95
"""A command of which this fraction was done was practically there."""
_ONE_INSTANT_S = 0.005
"""No loop of control sends its next goal sooner than this after the one before [s]."""
_ONWARD = 0.3
"""How far the goals of such a loop are apart at most, one from the next, of a joint [rad or m]."""
_ONWARD_GRIPPER = 0.005
"""The same of a gripper [rad or m]."""


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A command that was not carried out to its end."""

    command: IssuedCommand
    """The command."""
    code: str
    """That of its reason: docs/verdict.md."""
    words: str
    """What became of it."""
    by: Location | None = None
    """Where what replaced it was commanded."""


def unfinished(run: RecordedRun) -> Iterator[Unfinished]:
    """Yield the commands that another replaced on their way, and those that the end cut.

    Left out are those that were practically there, those of a loop that leads on from goal to
    goal, and velocities, which have no goal; what is cut where the controller was not done; and
    what a generic arm, whose speed nobody knows, did not reach in the time that it was given.
    """
    is_done = run.end.is_good and run.end.cause not in ("cycles", "duration")
    for command in run.commands:
        if command.way_done is None or command.way_done >= _ARRIVED:
            continue
        if command.end == "replaced":
            by = None if command.replaced_by is None else run.commands[command.replaced_by]
            if not run.is_speed_known and by is not None and not _at_once(command, by):
                continue
            if by is None or not _leads_on(command, by):
                place = None if by is None else _place_of(by, command)
                yield Unfinished(command, "command-replaced", _replaced(command, by), place)
        elif command.end == "cut_by_end" and is_done:
            words = f"{_so_far(command)} when the run ended"
            yield Unfinished(command, "command-cut", words)


def retry_of(run: RecordedRun, number: int) -> IssuedCommand | None:
    """Return the command of the same kind, function and goal that later succeeded.

    A gripper that closed past its goal on nothing opens to reach it: that is no grasp, unless the
    run has nothing to grasp.
    """
    command, later = run.commands[number], run.commands[number + 1 :]
    is_given = run.has_objects or any(issued_command.holds for issued_command in run.commands)
    is_vain = is_given and command.grip == "closes" and not command.holds
    return next(
        (
            issued_command
            for issued_command in later
            if issued_command.end == "arrived"
            and not (is_vain and issued_command.grip == "opens")
            and issued_command.kind == command.kind
            and issued_command.function == command.function
            and issued_command.elements == command.elements
            and is_near(issued_command.goal, command.goal)
        ),
        None,
    )


def _at_once(command: IssuedCommand, by: IssuedCommand) -> bool:
    return by.issue_s - command.issue_s <= _ONE_INSTANT_S


def _leads_on(command: IssuedCommand, by: IssuedCommand) -> bool:
    """Return whether one command follows another to the same goal, or as in a loop that tracks."""
    if by.elements == command.elements and is_near(command.goal, by.goal):
        return True
    return (
        by.path == command.path
        and not _at_once(command, by)
        and is_near(command.goal, by.goal, _ONWARD_GRIPPER if command.gripper else _ONWARD)
    )


def _so_far(command: IssuedCommand) -> str:
    first, *others = command.elements
    moved = first if not others else f"{first} and {len(others)} more"
    return f"a command to {moved} had come {100.0 * (command.way_done or 0.0):.0f} % of its way"


def _replaced(command: IssuedCommand, by: IssuedCommand | None) -> str:
    if by is None:
        return f"{_so_far(command)} when something else moved the robot"
    is_at_once = _at_once(command, by)
    after = "at once" if is_at_once else f"{by.issue_s - command.issue_s:.1f} s later"
    return f"{_so_far(command)} when it was replaced {after}"


def _place_of(command: IssuedCommand, other: IssuedCommand) -> Location | None:
    """Return the line that led to one command, and not to the other if there is such a line.

    Two commands of one helper are distinguished by the lines of the calls.
    """
    for (caller, site), (beside, elsewhere) in zip(command.path, other.path, strict=False):
        if caller != beside:
            break
        if site != elsewhere:
            return Location(caller.file, site[0])
    return command.location
