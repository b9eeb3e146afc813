"""What a verdict finds in the commands to grippers: grasps on nothing, idle and closed grippers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

from tracerisk.common.function_ref import FunctionRef
from tracerisk.instrument.recording import is_near
from tracerisk.pipeline.trace.recorded_run import IssuedCommand, RecordedRun
from tracerisk.trace import EndCause

if TYPE_CHECKING:
    from tracerisk.instrument.marks.call_log import Site

_Path: TypeAlias = "tuple[tuple[FunctionRef, Site], ...]"
_BY_ITSELF: frozenset[EndCause] = frozenset({"ended", "quiescent", "idle"})
"""How a controller comes to its end with nothing more to do."""


@dataclass(frozen=True, slots=True)
class EmptyGrasp:
    """A gripper that closed on nothing where it was to grasp, as it seems."""

    command: IssuedCommand
    """The command that closed it."""
    is_fault: bool
    """Whether it was meant to hold a thing, and the controller went on as if it held."""


def empty_grasps(commands: Sequence[IssuedCommand], *, has_objects: bool) -> Iterator[EmptyGrasp]:
    """Yield the grasps on nothing, also those that the controller noticed.

    The gripper closes and holds nothing, nor does it later at the same place. It was meant to hold
    something where the same call did so at another time in the run; or, in a run that never
    holds anything although the user gave it something to grasp, where the arm had moved with
    the gripper open. The controller went on as if it held where the arm then moves and the gripper
    opens, or is commanded to by a call that let go of something before: it may have opened already,
    where it closed on nothing.
    """
    closing = [issued_command for issued_command in commands if issued_command.grip == "closes"]
    held_at = {issued_command.path for issued_command in closing if issued_command.holds}
    releases = set(_releases(commands))
    for number, command in enumerate(commands):
        if command.grip != "closes" or command.holds or command.end_s is None:
            continue
        later = [
            issued_command
            for issued_command in commands[number + 1 :]
            if issued_command.path == command.path
        ]
        if any(
            issued_command.holds and is_near(issued_command.posture, command.posture)
            for issued_command in later
        ):
            continue
        is_grasp = command.path in held_at if held_at else _is_approached(commands, number)
        if is_grasp:
            is_fault = bool(held_at or has_objects) and _is_carried_on(commands, number, releases)
            yield EmptyGrasp(command, is_fault)


def closed_on_nothing(command: IssuedCommand) -> str:
    """Return which gripper closed on nothing, and where."""
    return f"{command.gripper} closed on nothing {command.place}".rstrip()


def _releases(commands: Sequence[IssuedCommand]) -> Iterator[_Path]:
    """Yield by which calls a gripper opened that held something."""
    holding: set[str] = set()
    for command in commands:
        if command.gripper in holding and command.grip == "opens":
            holding.discard(command.gripper)
            yield command.path
        if command.holds:
            holding.add(command.gripper)


def _is_carried_on(
    commands: Sequence[IssuedCommand], number: int, releases: Collection[_Path]
) -> bool:
    """Return whether the arm moves after an empty grasp, and the gripper is then to let go.

    The same call again, on the spot, is a retry, and opens a gripper that closed past its goal.
    What opens it there otherwise may be how the controller turns back; then only a call that is a
    release of things held says that it did not.
    """
    grasp = commands[number]
    has_moved = has_opened = False
    for command in commands[number + 1 :]:
        if command.gripper != grasp.gripper:
            has_moved |= not command.gripper
        elif has_moved and command.path in releases:
            return True
        elif command.grip == "closes" or (has_moved and not has_opened):
            return command.grip == "opens"
        elif command.path != grasp.path:
            has_opened = True
    return False


def _is_approached(commands: Sequence[IssuedCommand], number: int) -> bool:
    """Return whether the arm moved between the gripper's command before and this one."""
    for command in reversed(commands[:number]):
        if command.gripper == commands[number].gripper:
            return False
        if not command.gripper:
            return True
    return False


@dataclass(frozen=True, slots=True)
class GripperFault:
    """What is wrong with how a gripper was used."""

    code: str
    """That of its reason: docs/verdict.md."""
    words: str
    """What is wrong, in words."""
    command: IssuedCommand
    """The command that shows it."""


def gripper_faults(run: RecordedRun) -> Iterator[GripperFault]:
    """Yield what is wrong with how the grippers were used."""
    for empty_grasp in empty_grasps(run.commands, has_objects=run.has_objects):
        if empty_grasp.is_fault:
            told = closed_on_nothing(empty_grasp.command)
            words = f"{told}, and the controller went on as if it held"
            yield GripperFault("grasped-nothing", words, empty_grasp.command)
    is_vain = run.has_objects and not any(command.holds for command in run.commands)
    for name in dict.fromkeys(command.gripper for command in run.commands if command.gripper):
        own = [command for command in run.commands if command.gripper == name]
        if is_vain and _is_used(run.commands, own) and not _closes(own):
            words = "never closed"
        elif _is_idle(run.commands, own):
            words = "stayed as it was after the first time"
        else:
            words = ""
        if words:
            words = f"{name} was commanded {len(own)} times and {words}, so nothing was grasped"
            yield GripperFault("never-grasped", words, own[-1])
        if _is_left_closed(run, own):
            words = (
                f"{closed_on_nothing(own[-1])}, and was not opened again"
                if own[-1].place
                else f"{name} closed and was not opened again: what it takes is still held at the "
                "end"
            )
            yield GripperFault("never-released", words, own[-1])


def _is_used(commands: Sequence[IssuedCommand], own: Sequence[IssuedCommand]) -> bool:
    """Return whether the arm moves between commands to a gripper that say where it should go."""
    if not all(issued_command.goal for issued_command in own):
        return False
    between = commands[commands.index(own[0]) : commands.index(own[-1])]
    return any(not issued_command.gripper for issued_command in between)


def _closes(own: Sequence[IssuedCommand]) -> bool:
    return any(issued_command.grip == "closes" for issued_command in own)


def _is_idle(commands: Sequence[IssuedCommand], own: Sequence[IssuedCommand]) -> bool:
    """Return whether none of a gripper's commands but the first moves it, nor holds anything."""
    is_moved = any(issued_command.grip for issued_command in own[1:]) or any(
        issued_command.holds for issued_command in own
    )
    return _is_used(commands, own) and not is_moved


def _is_left_closed(run: RecordedRun, own: Sequence[IssuedCommand]) -> bool:
    """Return whether a gripper takes something at last and does not let it go, though it should.

    It closed by the call that was followed by a release before; or it holds something, and that
    was no pick.
    """
    last = own[-1]
    if last.grip == "opens":
        return False
    released = {
        one.path for one, then in pairwise(own) if one.grip == "closes" and then.grip == "opens"
    }
    if last.grip is not None and last.path in released:
        return True
    return last.holds and not _is_pick(run, last)


def _is_pick(run: RecordedRun, last: IssuedCommand) -> bool:
    """Return whether a run ends with what a last command holds because it was to pick it up.

    The arm moves on with it, the controller comes to its end by itself, and no gripper had let go
    of anything before: a mission that releases what it took otherwise is to release this, too.
    """
    at = run.commands.index(last)
    moves_on = any(not command.gripper for command in run.commands[at + 1 :])
    if run.end.cause not in _BY_ITSELF or not moves_on:
        return False
    holding: set[str] = set()
    for command in run.commands[:at]:
        if command.holds:
            holding.add(command.gripper)
        elif command.grip == "opens" and command.gripper in holding:
            return False
    return True
