"""What the process of a run writes while a controller runs.

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
from typing import Any, BinaryIO, Protocol

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location
from tracerisk.instrument.recording import SIGN, SignKind, is_near
from tracerisk.instrument.tracer import Frame
from tracerisk.trace import CommandEnd, EndCause

_FIGURE = re.compile(r"(?<![\w.])-?\d+\.\d+")
_WAY_DIGITS = 4  # of a fraction: differences in rounding between processors are smaller


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
            goal=[float(value) for value in goal],
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
        `goal` the final goal if it differs from the issued one [rad or m].
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
        named: Sequence[Location] = (),
        called_from: Location | None = None,
        time_ns: int | None = None,
    ) -> None:
        """Record what a user should know.

        `object_name` is what it is about, `target` the goal of what failed, `named` the places
        whose lines the message names, `called_from` the line that called, `time_ns` the
        time of the event if it is in the past [ns].
        """
        self._findings += 1
        further: dict[str, Any] = {} if time_ns is None else {"ns": time_ns}
        if named:
            further["named"] = [_location_data(place) for place in named]
        if called_from is not None:
            further["called_from"] = _location_data(called_from)
        self._write(
            "finding",
            kind=kind,
            message=message,
            location=_location_data(location),
            object=object_name,
            target=_goal(target),
            **further,
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
        named: Sequence[Location] = (),
        called_from: Location | None = None,
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
        self.finding(
            kind,
            message,
            location,
            object_name=object_name,
            target=goal,
            named=named,
            called_from=called_from,
        )
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

    def sign(self, by: SignKind, name: str, stack: Sequence[Frame] = ()) -> None:
        """Record that something went wrong in the controller's eyes, or in an answer to it.

        `stack` is that of the code that asked.
        """
        file, line = (stack[-1].function.file, stack[-1].site[0]) if stack else ("", 0)
        self.note(SIGN, by=by, name=name, ns=self.clock(), file=file, line=line)

    def run_ended(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        """Record the end of the run; only the first one counts."""
        self._write("end", cause=cause, message=message, location=_location_data(location))

    def _frames(self, stack: Sequence[Frame]) -> list[list[Any]]:
        return [
            [
                self._function(frame.function, frame.line),
                *(frame.activation, *frame.site, frame.root),
                *_optional_fields(frame),
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


def _optional_fields(frame: Frame) -> tuple[Any, ...]:
    """Return the fields that only few frames have."""
    if frame.through:
        return frame.instance, [[file, *site] for file, site in frame.through]
    return () if frame.instance is None else (frame.instance,)


def _location_data(location: Location | None) -> list[Any] | None:
    return None if location is None else [location.file, location.line, location.column]
