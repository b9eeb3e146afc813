"""Which calls a run executed, and where functions returned before they issued a command."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from contextvars import ContextVar
from dataclasses import dataclass, field
from types import AsyncGeneratorType, CodeType, CoroutineType, FrameType, GeneratorType
from typing import Any

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location
from tracerisk.instrument.code_positions import source_position
from tracerisk.instrument.hidden_frames import hide

CALLS = "calls"
"""The note of the calls that a run executed: what `CallLog.data` returns."""

Site = tuple[int, int]
"""Line and column of a call, both from 1 (the column in UTF-8 bytes)."""
Place = tuple[str, Site]
"""The file of a call, from the controller's root, and its site there."""

_MOST_WAITING = 100  # generators or coroutines of one call that have not begun; more say no more


@dataclass(frozen=True, slots=True)
class Turn:
    """One call of a function that returned, and what it executed."""

    place: Place
    """The place of the call."""
    function: FunctionRef
    """The function that was called."""
    executed: frozenset[Place]
    """The places of the calls that it executed before it returned."""


@dataclass(frozen=True, slots=True)
class Handled:
    """An `except` clause that ran."""

    file: str
    """The file, from the controller's root."""
    line: int
    """The first line of its body, from 1."""
    first_ns: int
    """When it first ran, in simulated time [ns]."""
    is_own: bool
    """Whether the controller itself had raised what it caught then."""


@dataclass(frozen=True, slots=True)
class Calls:
    """Which calls a run executed."""

    executed: frozenset[Place]
    """The places of the calls that were reached, those that raised included."""
    turns: tuple[Turn, ...]
    """The calls of functions that returned, each with what it executed."""
    raised: frozenset[Place]
    """The places of calls that a stand-in refused by an exception the last time."""
    waiting: frozenset[Place]
    """The places of calls that made generators or coroutines of which none ever began."""
    first_ns: Mapping[Place, int] = field(default_factory=dict)
    """When each place in `executed` was first reached, in simulated time [ns]."""
    handled: tuple[Handled, ...] = ()
    """The `except` clauses that ran."""

    @classmethod
    def of(cls, note: Mapping[str, Any]) -> Calls:
        """Read what `CallLog.data` returned."""
        turns = (
            Turn(
                place_of(key),
                FunctionRef(file, QualifiedName(name)),
                frozenset(map(place_of, executed)),
            )
            for key, file, name, executed in note["turns"]
        )
        return cls(
            frozenset(map(place_of, (*note["executed"], *note["raised"]))),
            tuple(turns),
            frozenset(map(place_of, note["raised"])),
            frozenset(map(place_of, note["waiting"])),
            dict(zip(map(place_of, note["executed"]), note["first_ns"], strict=True)),
            tuple(Handled(*handled) for handled in note["handled"]),
        )


class CallLog:
    """Notes the calls that a run executes. `top` holds the innermost link of the running code.

    `clock` (an attribute) returns the simulated time [ns].
    """

    def __init__(self, top: ContextVar[Any]) -> None:
        self.clock: Callable[[], int] = lambda: 0
        self._executed: dict[str, int] = {}
        self._raised: set[str] = set()
        # Keyed by ids because each return looks one up; the values keep the objects alive, so that
        # ids stay unique.
        self._turns: dict[tuple[int, int, int, frozenset[str]], tuple[CodeType, Any]] = {}
        self._ended: set[tuple[str, FunctionRef, frozenset[str]]] = set()
        self._began: set[str] = set()
        self._handled: dict[tuple[str, int], tuple[int, bool]] = {}
        self._waiting: dict[str, dict[FrameType, None]] = {}
        self._maker: dict[FrameType, str] = {}
        self.called = self._mark(top)
        """The mark: notes the call of a key, for the run and for the function that runs it."""

    def _mark(self, top: ContextVar[Any]) -> Callable[[str], None]:
        get, executed = top.get, self._executed

        @hide
        def called(key: str) -> None:
            if key not in executed:
                executed[key] = self.clock()
            link = get()
            if type(link) is tuple:
                link[3].add(key)

        return called

    @hide
    def made(self, key: str, value: Any) -> Any:
        """Note where a generator or a coroutine was made, and return it."""
        self.called(key)
        frame = _frame_of(value)
        if frame is not None and key not in self._began:
            waiting = self._waiting.setdefault(key, {})
            if len(waiting) < _MOST_WAITING:
                waiting[frame] = None
                self._maker[frame] = key
        return value

    def begun(self, frame: FrameType) -> str:
        """Note that a generator or a coroutine begins; return the key of the call that made it."""
        key = self._maker.pop(frame, "")
        if key:
            self._began.add(key)
            for other in self._waiting.pop(key, ()):
                self._maker.pop(other, None)
        return key

    def raised(self, place: Location) -> None:
        """Note that a stand-in refused a call; executing it again clears the note."""
        key = call_key(place.file, (place.line or 0, place.column or 0))
        if key in self._executed:
            del self._executed[key]
            self._raised.add(key)

    def handled(self, file: str, line: int, *, is_own: bool) -> None:
        """Note that an `except` clause runs; only the first time counts."""
        if (file, line) not in self._handled:
            self._handled[file, line] = self.clock(), is_own

    def returned(self, caller: FrameType, record: Any, executed: set[str]) -> None:
        """Note what a function, given by its record, executed, as it returns to its caller."""
        code = caller.f_code
        key = (id(code), caller.f_lasti, id(record), frozenset(executed))
        if key not in self._turns:
            self._turns[key] = (code, record)

    def ended(self, key: str, function: FunctionRef, executed: set[str]) -> None:
        """Note what a generator or a coroutine executed, once it has ended."""
        if key:
            self._ended.add((key, function, frozenset(executed)))

    def data(self, files: Mapping[str, str]) -> dict[str, Any]:
        """Return all that was noted, as JSON data; `files` are the names of code objects' files."""
        rows = [
            (_key_of(code, key[1], files), record.ref, key[3])
            for key, (code, record) in self._turns.items()
        ]
        turns = sorted(
            {
                (key, function.file, str(function.name), tuple(sorted(executed)))
                for key, function, executed in (*rows, *self._ended)
                if key
            }
        )
        return {
            "executed": sorted(self._executed),
            "first_ns": [first_ns for _, first_ns in sorted(self._executed.items())],
            "turns": [[*turn[:3], list(turn[3])] for turn in turns],
            "raised": sorted(self._raised - self._executed.keys()),
            "waiting": sorted(self._waiting),
            "handled": [[*place, *first] for place, first in sorted(self._handled.items())],
        }


def _frame_of(value: Any) -> FrameType | None:
    """Return the frame of what runs later than it was made, `None` for all else."""
    if isinstance(value, AbstractContextManager | AbstractAsyncContextManager):
        # What a decorator of `contextlib` makes of a generator.
        value = getattr(value, "gen", value)
    if isinstance(value, GeneratorType):
        return value.gi_frame
    if isinstance(value, CoroutineType):
        return value.cr_frame
    return value.ag_frame if isinstance(value, AsyncGeneratorType) else None


def call_key(file: str, site: Site) -> str:
    """Return what stands for a call in the text of a mark."""
    return f"{site[0]}:{site[1]}:{file}"


def _key_of(code: CodeType, instruction: int, files: Mapping[str, str]) -> str:
    file = files.get(code.co_filename)
    line, column = source_position(code, instruction)
    if file is None or line is None or column is None:
        return ""
    return call_key(file, (line, column + 1))


def place_of(key: str) -> Place:
    """Return the place of the call that has a key."""
    line, column, file = key.split(":", 2)
    return file, (int(line), int(column))
