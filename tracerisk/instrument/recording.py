"""What the child process writes while a controller runs, and the parent reads afterwards.

One JSON object a line, each written by one system call: a child that dies leaves whole lines,
but for the last.
"""

from __future__ import annotations

import itertools
import json
import math
import os
import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO, Protocol, cast, get_args

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.text.bounded import loads_json
from tracerisk.errors import Location, LogError, one_of
from tracerisk.instrument.commands import Command
from tracerisk.instrument.source.python_source import FunctionSite
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, EndCause, Finding

_SECOND_NS = 1_000_000_000
_FIGURE = re.compile(r"(?<![\w.])-?\d+\.\d+")
_WAY_DIGITS = 4  # of a fraction: what processors round differently is less


CELL = "cell"
"""The note of what the cell was asked for: `uses` in order, and the topics of `streams`."""
STOPS = "stops"
"""The note of the calls that brought the arm to rest: file, line and column of each."""


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


class CommandWatch(Protocol):
    """What is notified of commands as they are recorded."""

    def before_command(self, stack: Sequence[Frame]) -> None:
        """Note that a command is about to be issued; may end the run."""

    def issued(self, command_id: int, stack: Sequence[Frame], goal: Sequence[float]) -> None:
        """Note that a command was issued, and the positions to which it leads."""

    def ended(self, command_id: int, end: CommandEnd) -> None:
        """Note that a command ended, and how."""


class Recorder:
    """Writes the events of one run to `stream`, each line at once, until it is closed.

    `stream` is a file open for writing; only its descriptor is used. `clock` (an attribute, too)
    returns the simulated time [ns]. `watch` (an attribute) is notified of each command; `on_event`
    gets each event, its time [ns] and its data.
    """

    def __init__(self, stream: BinaryIO, *, clock: Callable[[], int]) -> None:
        self._stream = stream
        self.clock = clock
        self.watch: CommandWatch | None = None
        self.on_event: Callable[[str, int, Mapping[str, Any]], None] | None = None
        self._next_command = itertools.count(1).__next__
        self._functions: dict[tuple[FunctionRef, int], int] = {}
        self._findings = 0
        self._open: dict[
            tuple[str, Hashable, str, str, Location | None], tuple[int, tuple[float, ...]]
        ] = {}

    def command(
        self,
        kind: str,
        elements: Sequence[str],
        stack: Sequence[Frame],
        *,
        goal: Sequence[float] = (),
    ) -> int:
        """Record that a command is issued now; return its id, from 1 in the order of issue.

        `goal` are the positions to which it leads, one a joint [rad or m].

        Raises:
            ValueError: the stack is empty.
        """
        if not stack:
            raise ValueError("a command has at least one function on its stack")
        if self.watch is not None:
            self.watch.before_command(stack)
        command_id = self._next_command()
        self._write(
            "command",
            id=command_id,
            kind=kind,
            elements=list(elements),
            stack=self._frames(stack),
            goal=[float(each) for each in goal],
        )
        if self.watch is not None:
            self.watch.issued(command_id, stack, goal)
        return command_id

    def command_ended(
        self,
        command_id: int,
        end: CommandEnd,
        *,
        way_done: float | None = None,
        replaced_by: int | None = None,
        goal: Sequence[float] | None = None,
    ) -> None:
        """Record how a command ends now.

        `way_done` is the fraction of its way, `replaced_by` the id of the command that took over,
        `goal` where it led in the end if that is not where it was issued to [rad or m].
        """
        details: dict[str, Any] = {}
        if way_done is not None:
            details["way_done"] = round(way_done, _WAY_DIGITS)
        if replaced_by is not None:
            details["replaced_by"] = replaced_by
        if goal is not None:
            details["goal"] = [float(value) for value in goal]
        self._write("command_ended", id=command_id, end=end, **details)
        if self.watch is not None:
            self.watch.ended(command_id, end)

    def refused(self, kind: str, end: CommandEnd, stack: Sequence[Frame]) -> None:
        """Record a command that moves nothing: a `refused` goal, or an `ignored` message.

        Raises:
            ValueError: the stack is empty.
        """
        if not stack:
            raise ValueError("a command has at least one function on its stack")
        self._write("refused", kind=kind, end=end, stack=self._frames(stack))

    def function_ran(self, ref: FunctionRef, line: int) -> None:
        """Record the first run of a function; what a `Tracer` calls on each first run."""
        self._write("ran", function=self._function(ref, line))

    def source_compiled(self, file: str, source: bytes) -> None:
        """Record the bytes of one of the controller's files: all its lines are lines of these."""
        self._write("source", file=file, latin1=source.decode("latin-1"))

    def finding(
        self,
        kind: str,
        message: str,
        location: Location | None = None,
        *,
        object_name: str = "",
        target: Sequence[float] = (),
        time_ns: int | None = None,
    ) -> None:
        """Record what a user should know.

        `object_name` is what it is about, `target` the goal of what failed, `time_ns` when it
        happened where that was before [ns].
        """
        self._findings += 1
        earlier = {} if time_ns is None else {"ns": time_ns}
        self._write(
            "finding",
            kind=kind,
            message=message,
            location=_location_data(location),
            object=object_name,
            target=_goal(target),
            **earlier,
        )

    def failed(
        self,
        kind: str,
        message: str,
        location: Location | None,
        *,
        asker: Hashable,
        object_name: str = "",
        target: Sequence[float] = (),
    ) -> bool:
        """Record that something failed which the code at `asker` may try again.

        While it is not tried again with success the same failure is recorded once, whatever the
        figures in its message. Return whether it was recorded now.
        """
        key = (kind, asker, object_name, _FIGURE.sub("", message), location)
        goal = _goal(target)
        if key in self._open and is_near(self._open[key][1], goal):
            return False
        self._open[key] = (self._findings, goal)
        self.finding(kind, message, location, object_name=object_name, target=goal)
        return True

    @property
    def has_open_failures(self) -> bool:
        """Whether something failed that was not tried again with success."""
        return bool(self._open)

    def succeeded(
        self, kind: str, *, asker: Hashable, object_name: str = "", target: Sequence[float] = ()
    ) -> None:
        """Record that what failed before has now succeeded: same asker, object and goal."""
        if not self._open:
            return
        goal = _goal(target)
        tried = (kind, asker, object_name)
        for key, (number, wanted) in list(self._open.items()):
            if key[:3] == tried and is_near(wanted, goal):
                del self._open[key]
                self._write("recovered", finding=number)

    def note(self, kind: str, **data: Any) -> None:
        """Record free JSON data."""
        self._write("note", kind=kind, data=data)

    def run_ended(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        """Record the end of the run; only the first one counts."""
        self._write("end", cause=cause, message=message, location=_location_data(location))

    def _frames(self, stack: Sequence[Frame]) -> list[list[Any]]:
        return [
            [
                self._function(frame.function, frame.line),
                *(frame.activation, *frame.site, frame.root),
                *_further(frame),
            ]
            for frame in stack
        ]

    def _function(self, ref: FunctionRef, line: int) -> int:
        """Return the number that stands for a function, which its first use writes."""
        key = (ref, line)
        number = self._functions.get(key)
        if number is None:
            number = self._functions[key] = len(self._functions)
            self._write("function", id=number, file=ref.file, name=ref.name, line=line)
        return number

    def _write(self, event: str, **data: Any) -> None:
        if self._stream.closed:
            return  # a controller's `__del__` runs when the interpreter ends, after the run
        text = _json({"event": event, "ns": self.clock(), **data})
        line = memoryview(f"{text}\n".encode())
        while line:
            line = line[os.write(self._stream.fileno(), line) :]
        if self.on_event is not None:
            self.on_event(event, self.clock(), data)


def _json(event: dict[str, Any]) -> str:
    """Return an event as JSON; numbers that are not finite, which JSON has not, by their names."""
    try:
        return json.dumps(event, separators=(",", ":"), allow_nan=False)
    except ValueError:
        return json.dumps(_named(event), separators=(",", ":"), allow_nan=False)


def _named(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _named(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_named(entry) for entry in value]
    return str(float(value)) if isinstance(value, float) and not math.isfinite(value) else value


def _goal(target: Sequence[float]) -> tuple[float, ...]:
    """Return the goal of what failed; none where a number of it is not finite: it is no place."""
    goal = tuple(map(float, target))
    return goal if all(map(math.isfinite, goal)) else ()


def _further(frame: Frame) -> tuple[Any, ...]:
    """Return what few frames have."""
    if frame.through:
        return frame.instance, [[file, *site] for file, site in frame.through]
    return () if frame.instance is None else (frame.instance,)


NEAR = 0.02
"""Goals are the same whose values differ by no more [rad or m]."""


def is_near(goal: Sequence[float], other: Sequence[float], within: float = NEAR) -> bool:
    """Return whether two goals are the same: as many values, each `within` the other's."""
    return len(goal) == len(other) and all(
        abs(one - two) <= within for one, two in zip(goal, other, strict=True)
    )


def _location_data(location: Location | None) -> list[Any] | None:
    return None if location is None else [location.file, location.line, location.column]


def read_recording(path: Path | str) -> Recording:
    """Read an events file; a torn last line, all that a sudden death leaves, is passed over.

    Raises:
        LogError: the file cannot be read, or another line is not an event.
    """
    try:
        content = Path(path).read_bytes()
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
                f"{one_of(reader.handlers)}; record the run again",
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
        self.refused.append(
            Command(0, _text(event["kind"]), (), stack, time_ns, time_ns, _end(event))
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
        raise ValueError(f"{type(value).__name__} where text is")
    return value


def _location(data: Sequence[Any] | None) -> Location | None:
    if data is not None:
        file, *numbers = data
        if not isinstance(file, str) or any(type(n) not in (int, type(None)) for n in numbers):
            raise ValueError("its place is not a file with a line")
    return None if data is None else Location(*data)
