"""What happened in a run, as messages: its commands, visits, contacts and findings."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.instrument.commands import Command
from tracerisk.pipeline.recordings.recorded_topics import (
    COMMANDS,
    CONTACTS,
    FINDINGS,
    GOALS,
    VISITS,
)
from tracerisk.pipeline.recordings.writing.cdr import (
    WARN,
    Stamped,
    joint_message,
    log_message,
    text_message,
)

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_SECOND_NS = 1_000_000_000


def event_messages(trace: Trace, commands: Sequence[Command]) -> list[Stamped]:
    """Return all that happened in a run, in time; `commands` are its own, refused ones too."""
    return sorted([*_commands(commands), *_goals(commands), *_visits(trace), *_findings(trace)])


def _goals(commands: Sequence[Command]) -> Iterator[Stamped]:
    """Yield where each command led; one that gives velocities led nowhere."""
    for command in commands:
        if command.goal:
            data, _, _ = joint_message(command.issue_ns, command.elements, command.goal)
            yield Stamped(command.issue_ns, GOALS, data)


def _commands(commands: Sequence[Command]) -> Iterator[Stamped]:
    for command in commands:
        stack = [
            {"function": frame.function.name, "file": frame.function.file, "line": frame.line}
            for frame in command.stack
        ]
        lasts_ns = None if command.end_ns is None else command.end_ns - command.issue_ns
        data = {
            "id": command.id,
            "kind": command.kind,
            "function": command.stack[-1].function.name,
            "elements": command.elements,
            "stack": stack,
            "goal": command.goal,
            "duration_s": None if lasts_ns is None else lasts_ns / _SECOND_NS,
            "end": command.end,
            "way_done": command.way_done,
            "replaced_by": command.replaced_by,
        }
        yield Stamped(command.issue_ns, COMMANDS, _json(data))


def _visits(trace: Trace) -> Iterator[Stamped]:
    for visit in trace.visits:
        function = visit.function.name
        data = {
            "function": function,
            "file": visit.function.file,
            "outcome": visit.outcome,
            "duration_s": visit.duration_s,
            "elements": sorted(visit.exposures),
        }
        yield Stamped(_ns(visit.start_s), VISITS, _json(data))
        for touch in visit.contacts:
            data = {
                "link": touch.link,
                "other": touch.other,
                "function": function,
                "touching_s": touch.touching_s,
                "force_n": touch.force_n,
                "expected": touch.expected,
            }
            yield Stamped(_ns(touch.start_s), CONTACTS, _json(data))


def _findings(trace: Trace) -> Iterator[Stamped]:
    for finding in trace.findings:
        time_ns = _ns(finding.time_s or 0.0)
        place = finding.location
        message = log_message(
            time_ns,
            WARN,
            finding.kind,
            finding.message,
            file="" if place is None else place.file,
            function=finding.function,
            line=0 if place is None else place.line or 0,
        )
        yield Stamped(time_ns, FINDINGS, message)


def _ns(seconds: float) -> int:
    return max(0, round(seconds * _SECOND_NS))


def _json(data: Mapping[str, Any]) -> bytes:
    return text_message(json.dumps(data, ensure_ascii=False))
