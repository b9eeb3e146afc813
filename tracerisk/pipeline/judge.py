"""Judge a run: how far it can be taken for the mission; docs/theory.md#the-verdict-of-a-run.

`judge` is a pure function of what was recorded: it needs no simulation and no controller.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from tracerisk.errors import Location
from tracerisk.instrument.recording import is_near
from tracerisk.trace import (
    NEVER_RAN,
    VERDICTS,
    Acceptance,
    Coverage,
    Finding,
    Reason,
    RunEnd,
    Verdict,
    VerdictKind,
)

CODES: dict[str, VerdictKind] = {
    "command-aborted": "faulted",
    "command-rejected": "faulted",
    "command-ignored": "faulted",
    "service-refused": "faulted",
    "lookup-failed": "faulted",
    "ik-failed": "faulted",
    "fk-failed": "faulted",
    "planning-failed": "faulted",
    "path-cut": "faulted",
    "attach-failed": "faulted",
    "callback-raised": "faulted",
    "thread-raised": "faulted",
    "error-logged": "faulted",
    "run-raised": "faulted",
    "run-exited": "faulted",
    "grasped-nothing": "faulted",
    "object-dropped": "faulted",
    "object-knocked": "faulted",
    NEVER_RAN: "partial",
    "never-grasped": "partial",
    "unmet-need": "partial",
    "companion-failed": "partial",
    "robot-assumed": "partial",
    "input-assumed": "partial",
    "duration-cut": "partial",
    "run-deadlock": "stuck",
    "run-no-motion": "stuck",
    "run-wall-limit": "stuck",
    "run-memory-limit": "stuck",
    "run-died": "stuck",
    "run-not-importable": "stuck",
}
"""Every code of a reason, and what it makes of the run where it is not accepted."""

_OF_FINDING = {
    "execution_failure": "command-aborted",
    "goal_rejected": "command-rejected",
    "command_ignored": "command-ignored",
    "service_refused": "service-refused",
    "lookup_failure": "lookup-failed",
    "ik_failure": "ik-failed",
    "fk_failure": "fk-failed",
    "planning_failure": "planning-failed",
    "path_cut": "path-cut",
    "attach_failure": "attach-failed",
    "callback_failed": "callback-raised",
    "thread_failed": "thread-raised",
    "error_logged": "error-logged",
    "unprovided": "unmet-need",
    "companion_failed": "companion-failed",
}
_OF_COMMANDS = frozenset({"execution_failure", "goal_rejected"})

Grip = Literal["closes", "opens"]


@dataclass(frozen=True, slots=True)
class IssuedCommand:
    """A command as the judge sees it, with its outcome; times in [s]."""

    kind: str
    function: str
    """The qualified name of the function that issued it."""
    location: Location | None
    elements: tuple[str, ...]
    issue_s: float
    end_s: float | None = None
    outcome: str | None = None
    """`succeeded`, `aborted`, `preempted`; `None` where the run ended first."""
    goal: tuple[float, ...] = ()
    """Where it leads, one value a joint [rad or m]."""
    callers: tuple[str, ...] = ()
    """The functions on its stack, the one that issued it among them."""
    path: tuple[object, ...] = ()
    """The functions on its stack, each with the place of its call: the same for a loop."""
    gripper: str = ""
    """The gripper that it moves, empty for an arm's motion."""
    grip: Grip | None = None
    """Whether it closes or opens the gripper."""
    holds: bool = False
    """Whether something was held once the gripper had closed, before the arm moved on."""
    posture: tuple[float, ...] = ()
    """The positions of the arm's joints when it was issued [rad or m]."""


@dataclass(frozen=True, slots=True)
class UnmetNeed:
    """Something that the controller asked for in vain and went on without."""

    object: str
    words: str
    location: Location | None = None
    function: str = ""
    is_frame: bool = False


@dataclass(frozen=True, slots=True)
class Fall:
    """A thing that fell or tipped while nobody held it."""

    object: str
    time_s: float
    """When it was let go, or first touched [s]."""
    height_m: float
    """How far it came down [m]."""
    was_held: bool
    is_tipped: bool = False


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """All that the verdict of a run rests on."""

    end: RunEnd
    end_function: str = ""
    """The qualified name of the function in which it ended badly."""
    findings: tuple[Finding, ...] = ()
    commands: tuple[IssuedCommand, ...] = ()
    """In the order of issue."""
    unmet: tuple[UnmetNeed, ...] = ()
    coverage: Coverage = field(default_factory=lambda: Coverage(0, 0))
    falls: tuple[Fall, ...] = ()
    assumed: tuple[tuple[str, str], ...] = ()
    """What of the robot is assumed (the arm, a group, a gripper), each with the words for it."""
    unconfirmed: tuple[tuple[str, str, Location], ...] = ()
    """Entries of the scenario that nobody confirmed: name, words and place."""
    has_objects: bool = False
    """Whether the user gave the run something that can be grasped."""
    is_duration_given: bool = False
    """Whether the user said how long the run may last."""


def judge(run: RecordedRun, acceptances: Sequence[Acceptance] = ()) -> Verdict:
    """Return the verdict of a run with its reasons; accepted ones make it no worse."""
    reasons: tuple[Reason, ...] = _ordered(
        [
            *_of_findings(run),
            *_of_commands(run),
            *_of_grasps(run),
            *_of_open_grippers(run),
            *_of_falls(run),
            *_of_needs(run),
            *_of_assumptions(run),
            *_of_coverage(run.coverage),
            *_of_end(run),
        ]
    )
    return with_acceptances(Verdict("complete", reasons, run.coverage), acceptances)


def with_acceptances(verdict: Verdict, acceptances: Sequence[Acceptance]) -> Verdict:
    """Return the verdict under these acceptances alone; what is stuck is never accepted."""
    words = {each.key: each.words for each in acceptances}
    judged = [
        replace(each, accepted="" if each.verdict == "stuck" else words.get(each.key, ""))
        for each in verdict.reasons
    ]
    kind: VerdictKind = "complete"
    for each in judged:
        if not each.accepted and VERDICTS.index(each.verdict) > VERDICTS.index(kind):
            kind = each.verdict
    return Verdict(kind, _ordered(judged), verdict.coverage, tuple(acceptances))


def _ordered(reasons: Iterable[Reason]) -> tuple[Reason, ...]:
    def rank(reason: Reason) -> tuple[bool, int, float]:
        # Of one time those come first that were recorded first.
        time_s = float("inf") if reason.time_s is None else reason.time_s
        return bool(reason.accepted), -VERDICTS.index(reason.verdict), time_s

    found: dict[tuple[object, ...], Reason] = {}
    for each in sorted(reasons, key=rank):
        # What happens again and again at one place is one reason, of its first time.
        found.setdefault((each.key, each.location), each)
    return tuple(found.values())


def _reason(
    code: str,
    words: str,
    *,
    function: str = "",
    object_name: str = "",
    time_s: float | None = None,
    location: Location | None = None,
) -> Reason:
    return Reason(code, CODES[code], words, function, object_name, time_s, location)


def _of_end(run: RecordedRun) -> Iterator[Reason]:
    end = run.end
    if not end.is_good:
        yield _reason(
            end.code,
            end.message,
            function=run.end_function,
            time_s=end.simulated_s,
            location=end.location,
        )
    elif end.cause == "duration" and not run.is_duration_given:
        yield _reason(
            "duration-cut",
            "the default duration cut the run, so the figure rests on it; --duration S sets how "
            "long a mission lasts",
            object_name="duration",
            time_s=end.simulated_s,
        )


# Commands and what else failed, with their retries


def _of_commands(run: RecordedRun) -> Iterator[Reason]:
    """Yield commands that were aborted and of which no retry succeeded."""
    for number, command in enumerate(run.commands):
        if command.outcome != "aborted" or _retry(command, run.commands[number + 1 :]):
            continue
        told = _finding_of(command, run.findings)
        words = told.message if told else f"a command to {', '.join(command.elements)} was aborted"
        yield _reason(
            "command-aborted",
            words,
            function=command.function,
            object_name=told.object if told and told.object else ", ".join(command.elements),
            time_s=command.issue_s,
            location=command.location,
        )


def _retry(command: IssuedCommand, later: Sequence[IssuedCommand]) -> IssuedCommand | None:
    """Return the command of the same kind, function and goal that later succeeded."""
    return next(
        (
            each
            for each in later
            if each.outcome == "succeeded"
            and each.kind == command.kind
            and each.function == command.function
            and each.elements == command.elements
            and is_near(each.goal, command.goal)
        ),
        None,
    )


def _finding_of(command: IssuedCommand, findings: Sequence[Finding]) -> Finding | None:
    """Return the finding that says why a command was aborted."""
    return next(
        (
            each
            for each in findings
            if each.kind == "execution_failure" and _is_about(each, command)
        ),
        None,
    )


def _is_about(finding: Finding, command: IssuedCommand) -> bool:
    if command.outcome != "aborted" or finding.time_s is None or command.end_s is None:
        return False
    return (
        finding.function == command.function
        and command.issue_s <= finding.time_s
        and is_near(finding.target, command.goal)
    )


def _of_findings(run: RecordedRun) -> Iterator[Reason]:
    settled = list(_settled(run))
    for finding in run.findings:
        code = _OF_FINDING.get(finding.kind)
        if code is None or finding.recovered_s is not None:
            continue
        if finding.kind in _OF_COMMANDS and _is_told_by_command(finding, run.commands):
            continue
        if finding.kind == "error_logged" and _is_settled(finding, settled):
            continue
        if finding.kind == "execution_failure":
            # What never became a command was refused.
            code = "command-rejected"
        yield _reason(
            code,
            finding.message,
            function=finding.function,
            object_name=finding.object,
            time_s=finding.time_s,
            location=finding.location,
        )


def _is_told_by_command(finding: Finding, commands: Sequence[IssuedCommand]) -> bool:
    """Return whether a finding is of an aborted command, or of a goal that was met later."""
    if any(_is_about(finding, each) for each in commands):
        return True
    return bool(finding.target) and any(
        each.outcome == "succeeded"
        and each.function == finding.function
        and each.issue_s >= (finding.time_s or 0.0)
        and is_near(each.goal, finding.target)
        for each in commands
    )


_Span = tuple[frozenset[str], float, float]


def _settled(run: RecordedRun) -> Iterator[_Span]:
    """Yield the functions in which something failed until a retry succeeded, and from when on."""
    for finding in run.findings:
        if finding.recovered_s is not None and finding.time_s is not None:
            yield frozenset({finding.function}), finding.time_s, finding.recovered_s
    for number, command in enumerate(run.commands):
        if command.outcome == "aborted":
            retry = _retry(command, run.commands[number + 1 :])
            if retry is not None and retry.end_s is not None:
                yield frozenset(command.callers), command.issue_s, retry.end_s


def _is_settled(finding: Finding, spans: Iterable[_Span]) -> bool:
    time_s = finding.time_s or 0.0
    return any(
        finding.function in functions and start_s <= time_s <= end_s
        for functions, start_s, end_s in spans
    )


# Grasps and things that fall


@dataclass(frozen=True, slots=True)
class EmptyGrasp:
    """A gripper that closed on nothing, was carried on and opened; `intended`: to hold a thing."""

    command: IssuedCommand
    intended: bool


def empty_grasps(commands: Sequence[IssuedCommand], *, has_objects: bool) -> Iterator[EmptyGrasp]:
    """Yield the grasps on nothing with which a controller went on as if it held.

    The gripper closes and holds nothing, the arm moves, the gripper opens. It was meant to hold
    something where the same call did so at another time in the run; or, in a run that never
    holds anything although the user gave it something to grasp, where the arm had moved with
    the gripper open.
    """
    closing = [each for each in commands if each.grip == "closes"]
    held_at = {each.path for each in closing if each.holds}
    for number, command in enumerate(commands):
        if command.grip != "closes" or command.holds or not _is_carried_on(commands, number):
            continue
        later = [each for each in commands[number + 1 :] if each.path == command.path]
        if any(each.holds and is_near(each.posture, command.posture) for each in later):
            continue
        if held_at:
            if command.path in held_at:
                yield EmptyGrasp(command, intended=True)
        elif _is_approached(commands, number):
            yield EmptyGrasp(command, intended=has_objects)


def _is_carried_on(commands: Sequence[IssuedCommand], number: int) -> bool:
    """Return whether the arm moves after a command, and the gripper then opens."""
    has_moved = False
    for each in commands[number + 1 :]:
        if each.gripper == commands[number].gripper:
            return has_moved and each.grip == "opens"
        has_moved |= not each.gripper
    return False


def _is_approached(commands: Sequence[IssuedCommand], number: int) -> bool:
    """Return whether the arm moved between the gripper's command before and this one."""
    for each in reversed(commands[:number]):
        if each.gripper == commands[number].gripper:
            return False
        if not each.gripper:
            return True
    return False


def _of_grasps(run: RecordedRun) -> Iterator[Reason]:
    for each in empty_grasps(run.commands, has_objects=run.has_objects):
        if each.intended:
            command = each.command
            yield _reason(
                "grasped-nothing",
                f"{command.gripper} closed on nothing, and the controller went on as if it held",
                function=command.function,
                object_name=command.gripper,
                time_s=command.issue_s,
                location=command.location,
            )


def _of_open_grippers(run: RecordedRun) -> Iterator[Reason]:
    """Yield grippers that only ever open, although the user gave the run something to grasp."""
    if not run.has_objects or any(each.holds for each in run.commands):
        return
    for name in dict.fromkeys(each.gripper for each in run.commands if each.gripper):
        numbers = [at for at, each in enumerate(run.commands) if each.gripper == name]
        own = [run.commands[at] for at in numbers]
        between = run.commands[numbers[0] : numbers[-1]]
        if any(each.grip == "closes" or not each.goal for each in own):
            continue
        if any(not each.gripper for each in between):
            last = own[-1]
            yield _reason(
                "never-grasped",
                f"{name} was commanded {len(own)} times and never closed, so nothing was grasped",
                function=last.function,
                object_name=name,
                time_s=last.issue_s,
                location=last.location,
            )


def _of_falls(run: RecordedRun) -> Iterator[Reason]:
    for fall in run.falls:
        before = [each for each in run.commands if each.issue_s <= fall.time_s]
        cause = before[-1] if before else None
        what = f"fell {1000.0 * fall.height_m:.0f} mm"
        if fall.is_tipped:
            what = "tipped over"
        how = "after it was let go" if fall.was_held else "after the robot touched it"
        yield _reason(
            "object-dropped" if fall.was_held else "object-knocked",
            f"'{fall.object}' {what} {how}",
            function=cause.function if cause else "",
            object_name=fall.object,
            time_s=fall.time_s,
            location=cause.location if cause else None,
        )


# What was not there


def _of_needs(run: RecordedRun) -> Iterator[Reason]:
    looked_up = {each.object for each in run.findings if each.kind == "lookup_failure"}
    told = {each.object for each in run.findings if each.kind == "unprovided"}
    for need in run.unmet:
        if (need.is_frame and need.object in looked_up) or need.object in told:
            continue
        yield _reason(
            "unmet-need",
            f"nothing provides {need.words}",
            function=need.function,
            object_name=need.object,
            location=need.location,
        )


def _of_assumptions(run: RecordedRun) -> Iterator[Reason]:
    for name, words in run.assumed:
        yield _reason("robot-assumed", words, object_name=name)
    for name, words, place in run.unconfirmed:
        yield _reason("input-assumed", words, object_name=name, location=place)


def _of_coverage(coverage: Coverage) -> Iterator[Reason]:
    for each in coverage.never_ran:
        yield _reason(
            NEVER_RAN,
            f"{each.ref.name} can command hardware and never ran",
            function=each.ref.name,
            location=Location(each.ref.file, each.line),
        )
