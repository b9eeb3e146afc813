"""The tracer that the decorators call: which functions are active, and where each calls the next.

A call costs a context variable set twice; where in its source a function stands is read from
Python's own frames, and only when somebody asks (`Tracer.stack`), which a command does.
"""

from __future__ import annotations

import itertools
import sys
import threading
from collections.abc import Callable, Iterator
from contextvars import ContextVar, Token
from dataclasses import dataclass, field, replace
from types import CodeType, FrameType
from typing import Any, Literal

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location
from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.marks.call_log import CallLog, Place, Site, place_of
from tracerisk.instrument.marks.caught_exceptions import STAND_INS, CaughtFailure, caught_failure
from tracerisk.instrument.python_2.loader import serve_names
from tracerisk.instrument.python_frames import UNNAMED, enclosing_function, running_frame, site_of
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.source.python_source import FunctionSite
from tracerisk.instrument.state_instances import StateEntries
from tracerisk.instrument.wrappers import AnyFunction, wrap

RootKind = Literal["main", "thread", "callback", "done_callback", "timer", "service"]
"""How controller code comes to run when no controller code calls it."""


# Bound here: the run may show controllers a `sys._getframe` that hides the tracer's own frames.
_getframe = sys._getframe


@dataclass(frozen=True, slots=True)
class Frame:
    """One activation of a function on the stack of a command."""

    function: FunctionRef
    """The function that runs."""
    line: int
    """The line of its `def`, from 1."""
    activation: int
    """The number of this call, unique in the run."""
    site: Site
    """Where it calls the next frame or issues the command; its `def` and column 0 if unknown."""
    root: RootKind | None = None
    """How the function came to run where no controller code called it; else `None`."""
    instance: str | None = None
    """The label of the state that a state machine or behaviour tree entered here; empty if unknown,
    `None` where none was entered."""
    through: tuple[Place, ...] = ()
    """The other calls that led to it or on from it: those in lambdas, and the one that made it
    where it is a generator or a coroutine."""

    @property
    def places(self) -> tuple[Place, ...]:
        """The places of all these calls."""
        return ((self.function.file, self.site), *self.through)


_TURNS_AT_ONCE = 100
"""The turns of loops that `on_turns` gets at once."""
_LOOK_COST = 1000
"""For how many turns one counts of a loop that only looks: in Python they take about 1 ms."""


@dataclass(slots=True, eq=False)
class _Record:
    """A traced function."""

    ref: FunctionRef
    """The file and qualified name of the function."""
    line: int
    """The line of its `def`, from 1."""
    code: CodeType
    """The code object that identifies its frames."""


@dataclass(slots=True, eq=False)
class _Base:
    """The bottom of a stack: a root, or what a thread or a future inherited."""

    kind: RootKind
    """How the code came to run."""
    activation: int
    """The number of the activation."""
    inherited: tuple[Frame, ...] = ()
    """The stack of the code that created the thread or future, outermost first."""


# One link of a stack: (the caller's link or the base, the function, the activation, the keys of
# the calls that it executed, that of the call that made it if it runs later than that). A tuple,
# for one is made at each traced call.
_Link = tuple[Any, _Record, int, set[str], str]


@dataclass(frozen=True, slots=True)
class Captured:
    """The stack of the code that created a thread, a future or a task."""

    frames: tuple[Frame, ...]
    """The frames of the stack, outermost first."""


@dataclass(slots=True, eq=False)
class _Entered:
    """Context manager: the stack stands on `base` while it is open; may be entered again."""

    variable: ContextVar[Any]
    """The variable that holds the innermost link of the running code."""
    base: _Base
    """The bottom of the stack while it is open."""
    tokens: list[Token[Any]] = field(default_factory=list)
    """What resets the variable, one for each entry that is still open."""

    def __enter__(self) -> None:
        self.tokens.append(self.variable.set(self.base))

    def __exit__(self, *_: object) -> None:
        self.variable.reset(self.tokens.pop())


class Tracer:
    """Follows the functions of one run of a controller.

    `on_first_run` is called with each function the first time that it runs; `on_iteration` (an
    attribute) gets file and line of an endless loop at the beginning of each iteration; `on_turns`
    (an attribute) gets how many turns `while` loops have made; `on_source`
    (an attribute) gets each file of the controller and the bytes that were compiled; `on_caught`
    (an attribute) gets each call that a stand-in refused by an exception which the controller
    caught. `on_behalf` (an attribute) returns the stack of another function for whose sake the
    running code runs, if any.
    """

    def __init__(self, on_first_run: Callable[[FunctionRef, int], None] | None = None) -> None:
        self.top: ContextVar[Any] = ContextVar("tracerisk_stack", default=None)
        """The innermost link of the running code's stack."""
        self.next_activation = itertools.count(1).__next__
        self.calls = CallLog(self.top)
        self._on_first_run = on_first_run
        self.on_iteration: Callable[[str, int], None] | None = None
        self.on_turns: Callable[[int], None] | None = None
        self._turns = 0
        self.on_source: Callable[[str, bytes], None] | None = None
        self.on_caught: Callable[[CaughtFailure], None] | None = None
        self.ros_libraries: tuple[str, ...] = STAND_INS
        """The folders of the ROS libraries whose exceptions `on_caught` is called with."""
        self.on_behalf: Callable[[], tuple[Frame, ...]] | None = None
        self._ran: dict[FunctionRef, int] = {}
        self._files: dict[str, str] = {}
        self._libraries: set[str] = set()
        self._main_file = "<controller>"

    # --- what the loader reports

    def add_file(self, filename: str, file: str, *, is_library: bool = False) -> None:
        """Register `filename`, the name in code objects, as the controller's file `file`.

        The first file added is the script that runs. Functions of library code stand on no stack,
        as those of a library that is installed do not.
        """
        if not self._files:
            self._main_file = file
        if is_library:
            self._libraries.add(filename)
        else:
            self._files[filename] = file

    def traced(self, file: str, name: str, line: int) -> Callable[[AnyFunction], AnyFunction]:
        """Return the decorator of the function `name`, whose `def` stands in `line` of `file`."""
        ref = FunctionRef(file, QualifiedName(name))

        def decorate(function: AnyFunction) -> AnyFunction:
            return wrap(function, self, _Record(ref, line, function.__code__))

        return decorate

    @hide
    def looped(self, file: str, line: int) -> None:
        """Record that an iteration of an endless loop begins; instrumented loops call this."""
        if self.on_iteration is not None:
            self.on_iteration(file, line)

    @hide
    def turned(self) -> None:
        """Count a turn of a loop; instrumented loops call this."""
        self._turns += 1
        if self._turns == _TURNS_AT_ONCE:
            self._turns = 0
            if self.on_turns is not None:
                self.on_turns(_TURNS_AT_ONCE)

    @hide
    def waited(self) -> None:
        """Count a turn of a loop that only looks for what others do; such loops call this."""
        if self.on_turns is not None:
            self.on_turns(_LOOK_COST)

    @hide
    def caught(self) -> None:
        """Record what an `except` clause of the controller caught; instrumented ones call this."""
        error = sys.exc_info()[1]
        if error is not None:
            frame = _getframe(1)
            file = self._files.get(frame.f_code.co_filename)
            if file is not None:
                self.calls.handled(file, frame.f_lineno, is_own=self._is_raised_here(error))
            self.note_caught(error)

    def _is_raised_here(self, error: BaseException) -> bool:
        """Return whether the controller's own code raised an exception."""
        trace = error.__traceback__
        while trace is not None and trace.tb_next is not None:
            trace = trace.tb_next
        return trace is not None and trace.tb_frame.f_code.co_filename in self._files

    @hide
    def note_caught(self, error: BaseException) -> None:
        """Record an exception with which the controller goes on, if a ROS library raised it."""
        failure = caught_failure(error, self._files, self.ros_libraries)
        if failure is not None:
            self.calls.raised(failure.location)
            if self.on_caught is not None:
                self.on_caught(failure)

    @hide
    def run_module(
        self, code: CodeType, namespace: dict[str, Any], file: str, *, is_library: bool = False
    ) -> None:
        """Execute module-level code as the function `<module>` of `file`."""
        serve_names(code, namespace)
        record = _Record(FunctionRef(file, MODULE), 1, code)
        self.add_file(code.co_filename, file, is_library=is_library)
        self.first_run(record)
        token = self.top.set((self.top.get(), record, self.next_activation(), set(), ""))
        try:
            exec(code, namespace)
        finally:
            self.top.reset(token)

    # --- what the wrappers use

    def first_run(self, record: Any) -> None:
        """Note that a function runs; only the first time counts."""
        if record.ref not in self._ran:
            self._ran[record.ref] = record.line
            if self._on_first_run is not None:
                self._on_first_run(record.ref, record.line)

    # --- what the stand-ins ask

    def executed_calls(self) -> dict[str, Any]:
        """Return which calls of the controller's files were executed, as `Calls.of` reads them."""
        return self.calls.data(self._files)

    @property
    def functions_ran(self) -> tuple[FunctionSite, ...]:
        """Every function that ran, in the order of the first run of each."""
        return tuple(FunctionSite(ref, line) for ref, line in self._ran.items())

    def root(self, kind: RootKind) -> _Entered:
        """Return a context manager in which controller code runs as a root, with no caller."""
        return _Entered(self.top, _Base(kind, self.next_activation()))

    def capture(self) -> Captured:
        """Return the stack of the running code, for a thread or a future to inherit.

        Where no controller code runs the captured stack is empty.
        """
        return Captured(self._frames())

    def resume(self, captured: Captured) -> _Entered:
        """Return a context manager in which the stack goes on from a captured one."""
        return _Entered(self.top, _Base("thread", self.next_activation(), captured.frames))

    def stack(self) -> tuple[Frame, ...]:
        """Return the active functions of the running code, root first; never empty.

        A lambda given as a callback stands for the function that wrote it; a callback that is no
        controller code at all for `<module>` of the script.
        """
        if self.on_behalf is not None and (asking := self.on_behalf()):
            return asking
        frames = self._frames()
        if frames:
            return frames
        base = self.top.get()
        while isinstance(base, tuple):
            # Library code only: it runs for the root below.
            base = base[0]
        if not isinstance(base, _Base):
            base = _Base(_bare_root(), self.next_activation())
        frame = self._innermost_controller_frame()
        if frame is None:
            ref, site = FunctionRef(self._main_file, MODULE), (1, 0)
            return (Frame(ref, 1, base.activation, site, base.kind),)
        ref = FunctionRef(self._files[frame.f_code.co_filename], enclosing_function(frame))
        line = self._ran.get(ref, frame.f_code.co_firstlineno)
        return (Frame(ref, line, base.activation, site_of(frame), base.kind),)

    def where(self) -> Location | None:
        """Return where the innermost controller code stands, `None` where none runs."""
        frame = self._innermost_controller_frame()
        if frame is None:
            return None
        line, column = site_of(frame)
        return Location(self._files[frame.f_code.co_filename], line, column or None)

    def is_controllers(self, frame: FrameType | None) -> bool:
        """Return whether the code of a frame is the controller's own."""
        return frame is not None and frame.f_code.co_filename in self._files

    def where_failed(self, error: BaseException) -> Location | None:
        """Return the innermost controller line that an exception passed, `None` if it passed none.

        Follows the exception only, not its causes.
        """
        if isinstance(error, SyntaxError) and error.filename in self._files:
            return Location(self._files[error.filename], error.lineno, error.offset or None)
        location: Location | None = None
        traceback = error.__traceback__
        while traceback is not None:
            file = self._files.get(traceback.tb_frame.f_code.co_filename)
            if file is not None:
                location = Location(file, traceback.tb_lineno)
            traceback = traceback.tb_next
        return location

    # --- how

    def _innermost_controller_frame(self) -> FrameType | None:
        frame: FrameType | None = _getframe(1)
        while frame is not None and frame.f_code.co_filename not in self._files:
            frame = frame.f_back
        return frame

    def _frames(self) -> tuple[Frame, ...]:
        """Match the links of the stack with Python's frames, innermost first; no libraries."""
        links: list[_Link] = []
        link = self.top.get()
        while isinstance(link, tuple):
            if link[1].code.co_filename not in self._libraries:
                links.append(link)
            link = link[0]
        base: _Base | None = link
        inherited = base.inherited if base is not None else ()
        frames: list[Frame] = []
        entries = StateEntries()
        candidate: FrameType | None = _getframe(1)
        for position, (_, record, activation, _, made_at) in enumerate(links):
            frame, called = running_frame(candidate, record.code)
            through = tuple(self._lambdas(candidate, frame))
            if made_at:
                through += (place_of(made_at),)
            if frame is not None:
                site = site_of(called or frame)
                entries.passed(candidate, frame, record.ref.name)
                candidate = frame.f_back
            else:
                # It returned, or waits: a context was copied without `capture`.
                site = (record.line, 0)
                entries.unknown()
            is_root = position == len(links) - 1 and not inherited
            root = (base.kind if base is not None else _bare_root()) if is_root else None
            if is_root:
                through += tuple(self._lambdas(candidate, None))
            frames.append(Frame(record.ref, record.line, activation, site, root, through=through))
        known = next((item.instance for item in reversed(inherited) if item.instance), None)
        labels = entries.labels(known)
        frames = [
            item if label is None else replace(item, instance=label)
            for item, label in zip(frames, labels, strict=True)
        ]
        return (*inherited, *reversed(frames))

    def _lambdas(self, candidate: FrameType | None, until: FrameType | None) -> Iterator[Place]:
        """Yield where the lambdas of the controller stand, up to a frame or another function."""
        while candidate is not None and candidate is not until:
            file = self._files.get(candidate.f_code.co_filename)
            if file is not None:
                if candidate.f_code.co_name not in UNNAMED:
                    return
                yield file, site_of(candidate)
            candidate = candidate.f_back


def _bare_root() -> RootKind:
    is_main = threading.current_thread() is threading.main_thread()
    return "main" if is_main else "thread"
