"""Judge a run: how far it can be taken for the mission; docs/theory.md#the-verdict-of-a-run.

`judge` is a pure function of what was recorded: it needs no simulation and no controller.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from tracerisk.common.traced.findings import UNEXPECTED_CONTACT, Finding
from tracerisk.common.verdict import (
    INPUT_ASSUMED,
    MISSED_CALL,
    MISSION_MISSED,
    NEVER_CALLED,
    NEVER_RAN,
    UNUSED_INPUT,
    VERDICTS,
    Acceptance,
    Coverage,
    Reason,
    Verdict,
    VerdictKind,
)
from tracerisk.common.verdict_codes import CODES
from tracerisk.errors import Location
from tracerisk.instrument.recording import is_near
from tracerisk.pipeline.trace.falls import how_it_fell
from tracerisk.pipeline.trace.gripper_faults import gripper_faults
from tracerisk.pipeline.trace.recorded_run import (
    Fall,
    IssuedCommand,
    MissedCommand,
    MissedCondition,
    RecordedRun,
)
from tracerisk.pipeline.trace.unfinished import retry_of, unfinished

_OF_FINDING = {
    "execution_failure": "command-aborted",
    "goal_rejected": "command-rejected",
    "command_ignored": "command-ignored",
    "left_on": "command-left-on",
    "sent_early": "sent-early",
    "timed_out": "command-timed-out",
    "service_refused": "service-refused",
    "lookup_failure": "lookup-failed",
    "ik_failure": "ik-failed",
    "fk_failure": "fk-failed",
    "planning_failure": "planning-failed",
    "path_cut": "path-cut",
    "attach_failure": "attach-failed",
    "call_raised": "call-raised",
    "callback_failed": "callback-raised",
    "thread_failed": "thread-raised",
    "error_logged": "error-logged",
    "unprovided": "unmet-need",
    "foreign_gripper": "robot-assumed",
    "one_robot": "robot-assumed",
    "name_assumed": "robot-assumed",
    "distro_assumed": "distro-assumed",
    "past_limit": "past-limit",
    "stopped_at_limit": "stopped-at-limit",
    "denied": "access-denied",
    "unused": UNUSED_INPUT,
    "answer_assumed": INPUT_ASSUMED,
    "file_elsewhere": INPUT_ASSUMED,
    "functions_assumed": INPUT_ASSUMED,
    "companion_failed": "companion-failed",
}
_CAUSE_S = 1.0  # a touch that long before a thing falls may have made it fall [s]
_OF_COMMANDS = frozenset({"execution_failure", "goal_rejected"})


def judge(run: RecordedRun, acceptances: Sequence[Acceptance] = ()) -> Verdict:
    """Return the verdict of a run with its reasons; accepted ones make it no worse."""
    reasons: tuple[Reason, ...] = _ordered(
        [
            *_of_findings(run),
            *_of_commands(run),
            *_of_unfinished(run),
            *_of_limits(run.commands),
            *_of_grippers(run),
            *_of_falls(run),
            *_of_needs(run),
            *_of_assumptions(run),
            *_of_coverage(run.coverage),
            *_of_missed(run.missed),
            *_of_mission(run.mission),
            *_of_end(run),
        ]
    )
    return with_acceptances(Verdict("complete", reasons, run.coverage), acceptances)


def with_acceptances(verdict: Verdict, acceptances: Sequence[Acceptance]) -> Verdict:
    """Return the verdict under these acceptances alone; what is stuck is never accepted."""
    words = {acceptance.key: acceptance.words for acceptance in acceptances}
    judged = [
        replace(reason, accepted="" if reason.verdict == "stuck" else words.get(reason.key, ""))
        for reason in verdict.reasons
    ]
    kind: VerdictKind = "complete"
    for reason in judged:
        if not reason.accepted and VERDICTS.index(reason.verdict) > VERDICTS.index(kind):
            kind = reason.verdict
    return Verdict(kind, _ordered(judged), verdict.coverage, tuple(acceptances))


def _ordered(reasons: Iterable[Reason]) -> tuple[Reason, ...]:
    def rank(reason: Reason) -> tuple[bool, int, float]:
        # Of one time those come first that were recorded first.
        time_s = float("inf") if reason.time_s is None else reason.time_s
        return bool(reason.accepted), -VERDICTS.index(reason.verdict), time_s

    table: dict[tuple[object, ...], Reason] = {}
    for item in sorted(reasons, key=rank):
        # What happens again and again at one place is one reason, of its first time.
        table.setdefault((item.key, item.location), item)
    return tuple(table.values())


def _reason(
    code: str,
    words: str,
    *,
    function: str = "",
    object_name: str = "",
    time_s: float | None = None,
    location: Location | None = None,
    called_from: Location | None = None,
) -> Reason:
    return Reason(
        code,
        CODES[code],
        words,
        function,
        object_name,
        time_s,
        location,
        called_from=called_from,
    )


def _of_end(run: RecordedRun) -> Iterator[Reason]:
    end = run.end
    if end.is_good and not run.commands:
        words = "nothing was commanded, so no motion is in the figures"
        if run.coverage.never_ran_words:
            words = f"{words}: {run.coverage.never_ran_words}"
        yield _reason("no-command", words, time_s=end.simulated_s)
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
            f"the run was cut, so the figure rests on where: {end.message}; --duration S sets how "
            "long a mission lasts",
            object_name="duration",
            time_s=end.simulated_s,
        )


def _command_reason(
    code: str, words: str, command: IssuedCommand, object_name: str, *, at_end: bool = False
) -> Reason:
    """Return a reason about a command, at the instant of its end or else of its issue."""
    is_over = at_end and command.end_s is not None
    return _reason(
        code,
        words,
        function=command.function,
        object_name=object_name,
        time_s=command.end_s if is_over else command.issue_s,
        location=command.location,
        called_from=command.called_from,
    )


# Commands and what else failed, with their retries


def _of_commands(run: RecordedRun) -> Iterator[Reason]:
    """Yield commands that were aborted and of which no retry succeeded."""
    for number, command in enumerate(run.commands):
        if command.end != "aborted" or retry_of(run, number):
            continue
        finding = _finding_of(command, run.findings)
        words = (
            finding.message
            if finding
            else f"a command to {', '.join(command.elements)} was aborted"
        )
        name = finding.object if finding and finding.object else ", ".join(command.elements)
        yield _command_reason("command-aborted", words, command, name, at_end=True)


def _of_unfinished(run: RecordedRun) -> Iterator[Reason]:
    """Yield commands that were replaced or cut on their way, and did not succeed later either."""
    for result in unfinished(run):
        command = result.command
        if not retry_of(run, run.commands.index(command)):
            name = ", ".join(command.elements)
            yield replace(_command_reason(result.code, result.words, command, name), by=result.by)


def _finding_of(command: IssuedCommand, findings: Sequence[Finding]) -> Finding | None:
    """Return the finding that says why a command was aborted.

    What fails alike again and again is a finding of its first time alone.
    """
    failures = [finding for finding in findings if finding.kind == "execution_failure"]
    earlier = [
        finding
        for finding in failures
        if finding.location == command.location
        and finding.recovered_s is None
        and (finding.time_s or 0.0) <= command.issue_s
        and is_near(finding.target, command.goal)
    ]
    # A command may begin at the instant at which the one before it was aborted.
    return min(
        (finding for finding in failures if _is_about(finding, command)),
        key=lambda finding: finding.location != command.location,
        default=earlier[-1] if earlier else None,
    )


def _is_about(finding: Finding, command: IssuedCommand) -> bool:
    if command.end != "aborted" or finding.time_s is None or command.end_s is None:
        return False
    return (
        finding.function == command.function
        and command.issue_s <= finding.time_s
        and is_near(finding.target, command.goal)
    )


def _of_limits(commands: Sequence[IssuedCommand]) -> Iterator[Reason]:
    """Yield goals past a joint's limit that no other command's end reports."""
    for command in commands:
        if command.past_limit and command.end != "aborted":
            words = f"a goal takes joint '{command.past_limit}' {command.past_words}"
            yield _command_reason("past-limit", words, command, command.past_limit)


def _of_findings(run: RecordedRun) -> Iterator[Reason]:
    settled = list(_settled(run))
    for finding in run.findings:
        code = _OF_FINDING.get(finding.kind)
        if code is None or finding.recovered_s is not None:
            continue
        if finding.kind in _OF_COMMANDS and _is_reported_by_command(finding, run.commands):
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
            called_from=finding.called_from,
        )


def _is_reported_by_command(finding: Finding, commands: Sequence[IssuedCommand]) -> bool:
    """Return whether a finding is of an aborted command, or of a goal that was met later."""
    if any(_is_about(finding, command) for command in commands):
        return True
    return bool(finding.target) and any(
        command.end == "arrived"
        and command.function == finding.function
        and command.issue_s >= (finding.time_s or 0.0)
        and is_near(command.goal, finding.target)
        for command in commands
    )


_Span = tuple[frozenset[str], float, float]


def _settled(run: RecordedRun) -> Iterator[_Span]:
    """Yield the functions in which something failed until a retry succeeded, and from when on."""
    for finding in run.findings:
        if finding.recovered_s is not None and finding.time_s is not None:
            yield frozenset({finding.function}), finding.time_s, finding.recovered_s
    for number, command in enumerate(run.commands):
        if command.end == "aborted":
            retry = retry_of(run, number)
            if retry is not None and retry.end_s is not None:
                yield frozenset(command.callers), command.issue_s, retry.end_s


def _is_settled(finding: Finding, spans: Iterable[_Span]) -> bool:
    time_s = finding.time_s or 0.0
    return any(
        finding.function in functions and start_s <= time_s <= end_s
        for functions, start_s, end_s in spans
    )


# Grippers, and things that fall


def _of_grippers(run: RecordedRun) -> Iterator[Reason]:
    for fault in gripper_faults(run):
        yield _command_reason(fault.code, fault.words, fault.command, fault.command.gripper)


def _of_falls(run: RecordedRun) -> Iterator[Reason]:
    for fall in run.falls:
        before = [command for command in run.commands if command.issue_s <= fall.time_s]
        cause = before[-1] if before else None
        code, words = how_it_fell(fall)
        words += _touched_before(fall, run.findings)
        yield _reason(
            code,
            f"'{fall.object}' {words}",
            function=cause.function if cause else "",
            object_name=fall.object,
            time_s=fall.time_s,
            location=cause.location if cause else None,
            called_from=cause.called_from if cause else None,
        )


def _touched_before(fall: Fall, findings: Sequence[Finding]) -> str:
    """Return in words which unexpected contact of a thing may have made it fall; empty for none."""
    for finding in findings:
        since_s = fall.time_s - (finding.time_s or 0.0)
        is_of_it = re.search(rf"(?<!\w){re.escape(fall.object)}(?!\w)", finding.message)
        if finding.kind == UNEXPECTED_CONTACT and is_of_it and 0.0 <= since_s <= _CAUSE_S:
            return f" ({finding.message.partition(';')[0]}, {since_s:.2f} s before)"
    return ""


# What was not there


def _of_needs(run: RecordedRun) -> Iterator[Reason]:
    looked_up = {finding.object for finding in run.findings if finding.kind == "lookup_failure"}
    # A finding has said it, and more of it.
    told = {
        finding.object
        for finding in run.findings
        if finding.kind in ("unprovided", "answer_assumed")
    }
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
        yield _reason(INPUT_ASSUMED, words, object_name=name, location=place)


def _of_coverage(coverage: Coverage) -> Iterator[Reason]:
    for never in coverage.never_ran:
        if not never.is_spare:
            yield _reason(
                NEVER_RAN,
                f"{never.ref.name} can command hardware and never ran",
                function=never.ref.name,
                location=Location(never.ref.file, never.line),
            )


def _of_missed(missed: Sequence[MissedCommand]) -> Iterator[Reason]:
    for call in missed:
        words = f"this call of {call.call} never ran: what it would command is in no figure"
        if call.was_executed:
            words = f"this call of {call.call} led to no command; another did"
        yield _reason(
            MISSED_CALL if call.was_executed else NEVER_CALLED,
            words,
            function=call.function,
            object_name=call.call,
            location=call.location,
        )


def _of_mission(mission: Sequence[MissedCondition]) -> Iterator[Reason]:
    for condition in mission:
        code, words = MISSION_MISSED, condition.words
        if condition.is_assumed:
            code = INPUT_ASSUMED
            words += (
                "; nobody has confirmed this line of success: correct it, or delete its mark where "
                "the mission is so"
            )
        yield _reason(code, words, object_name=condition.object, location=condition.location)
