"""What a run left in its events file, as the parent reads it afterwards."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, cast, get_args

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes, loads_json
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location, LogError, one_of
from tracerisk.instrument.commands import Command
from tracerisk.instrument.source.python_source import FunctionSite
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, EndCause

_SECOND_NS = 1_000_000_000

CELL = "cell"
"""The note of what the cell was asked for: `uses` in order, and the topics of `streams`."""
STOPS = "stops"
"""The note of the calls that brought the arm to rest: file, line and column of each."""

SIGN = "sign"
"""The note of a `Sign`: its fields."""
SignKind = Literal["result", "code", "log"]
"""A `result` that says no success, a `code` of a failure, a line of the `log` at WARN or above."""


@dataclass(frozen=True, slots=True)
class Sign:
    """Something that went wrong in an answer to the controller, or in its own eyes."""

    by: SignKind
    """Whether it was answered by a result or a code, or wrote into its log."""
    name: str
    """The name of the action or service, or the line of the log with each number as `#`."""
    ns: int
    """When it happened, in simulated time [ns]."""
    file: str = ""
    """The file of the code that asked, from the controller's root; empty where none is known."""
    line: int = 0
    """The line there that asked; 0 where none is known."""


@dataclass(frozen=True, slots=True)
class Note:
    """Data that a part of the child process left for its counterpart in the parent."""

    kind: str
    """The name by which the counterpart finds it, such as `CELL`."""
    data: Mapping[str, Any]
    """The content, as JSON has it."""


@dataclass(frozen=True, slots=True)
class RecordedEnd:
    """How the run ended, as the child process recorded it."""

    cause: EndCause
    """The cause of the end."""
    message: str
    """The cause in one sentence, for the user."""
    time_ns: int
    """The simulated time of the end [ns]."""
    location: Location | None = None
    """The line of the controller at the end; `None` where none is known."""


@dataclass(frozen=True, slots=True)
class Recording:
    """All that one run left in its events file."""

    commands: tuple[Command, ...] = ()
    """The commands, in the order of issue."""
    refused: tuple[Command, ...] = ()
    """The commands that moved nothing, in the order of issue."""
    functions_ran: tuple[FunctionSite, ...] = ()
    """The functions that ran, in the order of their first run."""
    findings: tuple[Finding, ...] = ()
    """The findings, in the order in which they were recorded."""
    notes: tuple[Note, ...] = ()
    """The notes, in the order in which they were recorded."""
    end: RecordedEnd | None = None
    """The recorded end; `None` where the child died without one."""
    last_ns: int = 0
    """The simulated time of the last event [ns]."""
    sources: Mapping[str, bytes] = field(default_factory=dict)
    """The bytes of the controller's compiled files, by path from its root."""

    def note(self, kind: str) -> Mapping[str, Any] | None:
        """Return the data of the last note of a kind, `None` where there is none."""
        return next((note.data for note in reversed(self.notes) if note.kind == kind), None)

    @property
    def signs(self) -> tuple[Sign, ...]:
        """What went wrong in answers to the controller, and in its log, in order."""
        return tuple(Sign(**note.data) for note in self.notes if note.kind == SIGN)


NEAR = 0.02
"""Goals are the same whose values differ by no more [rad or m]."""


def is_near(goal: Sequence[float], other: Sequence[float], within: float = NEAR) -> bool:
    """Return whether two goals are the same: as many values, each `within` the other's."""
    return len(goal) == len(other) and all(
        abs(one - two) <= within for one, two in zip(goal, other, strict=True)
    )


def read_recording(path: Path | str) -> Recording:
    """Read an events file; a torn last line, all that a sudden death leaves, is passed over.

    Raises:
        LogError: the file cannot be read, or another line is not an event.
    """
    try:
        content = file_bytes(path, MOST_OF_A_RUN)
    except OSError as error:
        raise LogError(
            f"the recording cannot be read: {error.strerror}", Location(str(path))
        ) from error
    reader = _Reader()
    lines = content.split(b"\n")
    for number, line in enumerate(lines, start=1):
        try:
            if line:
                reader.read(loads_json(line))
        except (LookupError, ValueError, TypeError, AttributeError, RecursionError) as error:
            if number == len(lines):
                break
            raise LogError(
                f"not an event of a recording ({error}); "
                f"{one_of(reader.handlers)}; `tracerisk run FILE --keep DIR` records it again",
                Location(str(path), number),
            ) from error
    return reader.recording()


@dataclass(slots=True)
class _Reader:
    """Gathers the events of a recording as its lines are read."""

    functions: list[FunctionSite] = field(default_factory=list)
    """The functions by the number that stands for them in other events."""
    commands: dict[int, Command] = field(default_factory=dict)
    """The commands so far, by id."""
    refused: list[Command] = field(default_factory=list)
    """The commands that moved nothing, so far."""
    ran: dict[FunctionRef, FunctionSite] = field(default_factory=dict)
    """The functions that ran, with the line of their `def`."""
    findings: list[Finding] = field(default_factory=list)
    """The findings so far; a `recovered` event names one by its index."""
    notes: list[Note] = field(default_factory=list)
    """The notes so far."""
    end: RecordedEnd | None = None
    """The first recorded end; `None` before there is one."""
    last_ns: int = 0
    """The greatest time of an event so far [ns]."""
    sources: dict[str, bytes] = field(default_factory=dict)
    """The bytes of the compiled files, by path from the controller's root."""

    @property
    def handlers(self) -> dict[str, Callable[[dict[str, Any]], None]]:
        return {
            "function": self._function,
            "ran": self._ran,
            "source": self._source,
            "command": self._command,
            "command_ended": self._command_ended,
            "refused": self._refused,
            "finding": self._finding,
            "recovered": self._recovered,
            "note": self._note,
            "end": self._end,
        }

    def read(self, event: dict[str, Any]) -> None:
        if type(event["ns"]) is not int or not 0 <= event["ns"] < 2**63:
            raise ValueError("its time is not a whole number of nanoseconds")
        self.handlers[event["event"]](event)
        self.last_ns = max(self.last_ns, event["ns"])

    def recording(self) -> Recording:
        return Recording(
            tuple(self.commands.values()),
            tuple(self.refused),
            tuple(self.ran.values()),
            tuple(self.findings),
            tuple(self.notes),
            self.end,
            self.last_ns,
            self.sources,
        )

    def _function(self, event: dict[str, Any]) -> None:
        ref = FunctionRef(_text(event["file"]), QualifiedName(_text(event["name"])))
        if type(event["line"]) is not int:
            raise ValueError("its line is not a whole number")
        self.functions.append(FunctionSite(ref, event["line"]))

    def _ran(self, event: dict[str, Any]) -> None:
        site = self.functions[event["function"]]
        self.ran.setdefault(site.ref, site)

    def _source(self, event: dict[str, Any]) -> None:
        self.sources[_text(event["file"])] = _text(event["latin1"]).encode("latin-1")

    def _command(self, event: dict[str, Any]) -> None:
        self.commands[event["id"]] = Command(
            event["id"],
            _text(event["kind"]),
            tuple(map(_text, event["elements"])),
            self._stack(event),
            event["ns"],
            goal=tuple(map(float, event.get("goal", ()))),
        )

    def _command_ended(self, event: dict[str, Any]) -> None:
        command = self.commands[event["id"]]
        if command.end_ns is None:
            way_done, by = event.get("way_done"), event.get("replaced_by")
            if by is not None and by not in self.commands:
                raise ValueError(f"no command {by!r} was issued that could replace it")
            self.commands[event["id"]] = replace(
                command,
                end_ns=event["ns"],
                end=_end(event),
                way_done=None if way_done is None else float(way_done),
                replaced_by=by,
                goal=tuple(map(float, event.get("goal", command.goal))),
            )

    def _refused(self, event: dict[str, Any]) -> None:
        stack, time_ns = self._stack(event), event["ns"]
        last = next(reversed(self.commands), 0)
        self.refused.append(
            Command(0, _text(event["kind"]), (), stack, time_ns, time_ns, _end(event), after=last)
        )

    def _stack(self, event: dict[str, Any]) -> tuple[Frame, ...]:
        frames = []
        for number, activation, line, column, root, *further in event["stack"]:
            site = self.functions[number]
            instance = further[0] if further else None
            through = tuple(_place(*place) for place in (further[1] if len(further) > 1 else ()))
            frames.append(
                Frame(site.ref, site.line, activation, (line, column), root, instance, through)
            )
        return tuple(frames)

    def _finding(self, event: dict[str, Any]) -> None:
        time_s = event["ns"] / _SECOND_NS
        self.findings.append(
            Finding(
                _text(event["kind"]),
                _text(event["message"]),
                time_s,
                _location(event["location"]),
                object=_text(event.get("object", "")),
                target=tuple(map(float, event.get("target", ()))),
                called_from=_location(event.get("called_from")),
                named=tuple(place for data in event.get("named", ()) if (place := _location(data))),
            )
        )

    def _recovered(self, event: dict[str, Any]) -> None:
        number = event["finding"]
        time_s = event["ns"] / _SECOND_NS
        self.findings[number] = replace(self.findings[number], recovered_s=time_s)

    def _note(self, event: dict[str, Any]) -> None:
        if not isinstance(event["data"], dict):
            raise ValueError("its data are no object")
        self.notes.append(Note(_text(event["kind"]), event["data"]))

    def _end(self, event: dict[str, Any]) -> None:
        if event["cause"] not in get_args(EndCause):
            raise ValueError(f"unknown end {event['cause']!r}")
        if self.end is None:
            self.end = RecordedEnd(
                event["cause"], _text(event["message"]), event["ns"], _location(event["location"])
            )


def _end(event: dict[str, Any]) -> CommandEnd:
    if event["end"] not in get_args(CommandEnd):
        raise ValueError(f"unknown end of a command {event['end']!r}")
    return cast(CommandEnd, event["end"])


def _place(file: Any, line: int, column: int) -> tuple[str, tuple[int, int]]:
    return _text(file), (line, column)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{type(value).__name__} where text is expected")
    return value


def _location(data: Sequence[Any] | None) -> Location | None:
    if data is not None:
        file, *numbers = data
        if not isinstance(file, str) or any(type(n) not in (int, type(None)) for n in numbers):
            raise ValueError("its place is not a file with a line")
    return None if data is None else Location(*data)
