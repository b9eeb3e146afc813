"""How a controller ends: watched in its process, noted in the recording."""

from __future__ import annotations

import contextlib
import dataclasses
import mmap
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import FrameType, TracebackType
from typing import NoReturn

from tracerisk.common.text.printable import cut, printable
from tracerisk.errors import Location, SourceError, UnsafeRewriteError
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.run.missing_modules import MissingModules
from tracerisk.pipeline.run.needs.unmet_needs import JudgedEnd
from tracerisk.pipeline.trace.run_files import NEEDS, OBJECTS, SCENARIO
from tracerisk.ros.controller.frames import is_library
from tracerisk.ros.controller.removed_names import removed_name_hint
from tracerisk.ros.imports.panels.window_names import needs_screen, no_screen
from tracerisk.ros.time.scheduler import RunOver
from tracerisk.trace import EndCause
from tracerisk.twin.simulation.twin import Twin

_CONTEXTS = 20
_RESERVE_BYTES = 32 * 1024 * 1024
_BY_ITSELF = frozenset({"ended", "exited", "raised"})


@dataclasses.dataclass(slots=True, eq=False)
class ControllerEnd:
    """Notes in the recording how the run of the controller ended, once."""

    recorder: Recorder
    """The recording of the run."""
    twin: Twin
    """The twin, for where objects are at the end."""
    root: Path
    """The folder of the controller, from which the recording names files."""
    memory_limit_mb: int
    """The memory that the process may take [MB], for the message."""
    run_over: Callable[[EndCause], None] = lambda _: None
    """Called with the cause of the end before it is recorded."""
    judge: Callable[[EndCause, str, Location | None], JudgedEnd] = JudgedEnd
    """Returns what the end is in the light of what the controller lacked."""
    missing: MissingModules | None = None
    """Finds modules that are absent; `None` for no search."""
    outlast: Callable[[], None] = lambda: None
    """Carries out what a controller that ended by itself had left under way."""
    before_exit: Callable[[], None] = lambda: None
    """Called before the controller, or this, ends the process at once."""
    on_missing: Callable[[Mapping[str, str], Location | None], None] = lambda *_: None
    """Called with the modules for which placeholders may stand, and with the place that failed."""
    _reported: bool = dataclasses.field(default=False, init=False)
    """Whether the end is recorded."""
    _reserve: mmap.mmap = dataclasses.field(
        default_factory=lambda: mmap.mmap(-1, _RESERVE_BYTES, prot=mmap.PROT_READ), init=False
    )
    """Address space for the report of a lack of memory, which nothing fills."""
    _owner: int = dataclasses.field(default_factory=os.getpid, init=False)
    """The id of the process whose end is reported."""

    def forked(self) -> None:
        """Report the end of this process, which was forked from the one that began."""
        self._owner = os.getpid()

    def run(self, run: Callable[[], None]) -> None:
        """Run the controller, and record how it ended."""
        with self._exit_watched(), self._threads_watched():
            try:
                run()
            except RunOver as over:
                self._over(over)
            except SystemExit as error:
                self._exited(error)
            except MemoryError as error:
                self._out_of_memory(error)
            except BaseException as error:  # noqa: BLE001 - here the controller ends
                self._raised(error)
            else:
                self._report("ended", "the controller ended")

    def kill(self, over: RunOver) -> None:
        """Report how the run is over, and end a process that does not react."""
        self._over(over)
        self.before_exit()
        os.kill(os.getpid(), signal.SIGKILL)

    def abort(self, message: str, place: Location | None) -> NoReturn:
        """Report that the process aborts, and end it: no code of the controller runs any more."""
        self._over(RunOver("raised", message, place))
        with contextlib.suppress(OSError, ValueError, AttributeError):
            sys.stdout.flush()
        os._exit(128 + signal.SIGABRT)

    def _report(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        if self._reported:
            return
        self._reported = True
        if cause in _BY_ITSELF:
            self.outlast()
        self.recorder.note(
            OBJECTS,
            found=[dataclasses.asdict(offset) for offset in self.twin.object_offsets()],
            bearing=self.twin.bearing(),
        )
        judged = self.judge(cause, message, location)
        if judged.scenario:
            self.recorder.note(SCENARIO, lines=judged.scenario)
        if judged.needs:
            needs = [[need.kind, need.name, need.type_name] for need in judged.needs]
            self.recorder.note(NEEDS, needs=needs)
        self.run_over(judged.cause)
        self.recorder.run_ended(judged.cause, judged.message, judged.location)

    def _over(self, over: RunOver) -> None:
        place = over.location
        if place is not None and self._is_controllers(place.file):
            place = dataclasses.replace(place, file=self._below_root(place.file))
        self._report(over.cause, over.message, place)

    def _exited(self, error: SystemExit) -> None:
        code = error.code
        if code in (None, 0):
            self._report("ended", "the controller ended")
            return
        text = f"with code {code}" if isinstance(code, int) else f"with the message: {code}"
        self._report("exited", f"the controller exited {text}", self._place_of(error))

    def _out_of_memory(self, error: MemoryError) -> None:
        self._reserve.close()
        message = (
            f"the controller ran out of memory: its process may take {self.memory_limit_mb} MB "
            "(--memory-limit)"
        )
        self._report("memory_limit", message, self._place_of(error))
        _print_traceback(error)

    def _raised(self, error: BaseException) -> None:
        if isinstance(error, ModuleNotFoundError):
            place = self._place_of(error)
            self._report("not_importable", self._not_there(error, place), place)
            return
        if isinstance(error, SyntaxError) and self._is_controllers(error.filename or ""):
            place = Location(self._below_root(error.filename or ""), error.lineno, error.offset)
            self._report("not_importable", f"not valid Python: {error.msg}", place)
            return
        if isinstance(error, SourceError | UnsafeRewriteError):
            # A module that it imports cannot be read or instrumented.
            self._report("not_importable", error.message, error.location)
            return
        hint = removed_name_hint(error)
        if needs_screen(error):
            self.on_missing({"tkinter": ""}, self._place_of(error))
            hint = no_screen("tkinter")
        message = f"the controller raised {_one_text(error)}" + (f"; {hint}" if hint else "")
        self._report("raised", message, self._place_of(error))
        _print_traceback(error)

    def _not_there(self, error: ModuleNotFoundError, place: Location | None) -> str:
        """Return which modules are not there; of a part of a package, what the error says."""
        name = error.name or ""
        plain = f"No module named '{name}'"
        if self.missing is None or not str(error).startswith(plain):
            return str(error)
        parent, _, _ = name.partition(".")
        if parent != name and parent in sys.modules:
            return str(error)
        self.on_missing(self.missing.replaceable(name), place)
        return self.missing.sentence(name)

    def _exited_at_once(self, code: int, frame: FrameType | None) -> None:
        while frame is not None and not self._is_controllers(frame.f_code.co_filename):
            frame = frame.f_back
        place = None if frame is None else self._location(frame, frame.f_lineno)
        if code == 0:
            self._report("ended", "the controller ended by os._exit(0)", place)
        else:
            self._report("exited", f"the controller called os._exit({code})", place)

    @contextlib.contextmanager
    def _exit_watched(self) -> Iterator[None]:
        """Make `os._exit` record where it was called before it ends the process."""
        real = os._exit

        def notify(status: int) -> None:
            if os.getpid() == self._owner:
                self._exited_at_once(status, sys._getframe(1))
                self.before_exit()
            real(status)

        os._exit = notify  # type: ignore[assignment]
        try:
            yield
        finally:
            os._exit = real

    @contextlib.contextmanager
    def _threads_watched(self) -> Iterator[None]:
        """Make a finding of each thread that dies of an error, with which Python goes on."""
        real = threading.excepthook

        def notify(failure: threading.ExceptHookArgs) -> None:
            error, thread = failure.exc_value, failure.thread
            if error is not None and not isinstance(error, SystemExit | RunOver):
                name = "" if thread is None else f" {thread.name}"
                message = f"thread{name} died of {_one_text(error)}, and the controller went on"
                self.recorder.finding("thread_failed", message, self._place_of(error))
            real(failure)

        threading.excepthook = notify
        try:
            yield
        finally:
            threading.excepthook = real

    def _place_of(self, error: BaseException) -> Location | None:
        """Return the controller's innermost place in the error, or in one that led to it."""
        cause: BaseException | None = error
        for _ in range(_CONTEXTS):
            if cause is None:
                return None
            place = self._innermost(cause.__traceback__)
            if place is not None:
                return place
            cause = cause.__cause__ or cause.__context__
        return None

    def _innermost(self, trace: TracebackType | None) -> Location | None:
        place = None
        while trace is not None:
            if self._is_controllers(trace.tb_frame.f_code.co_filename):
                place = self._location(trace.tb_frame, trace.tb_lineno)
            trace = trace.tb_next
        return place

    def _is_controllers(self, file: str) -> bool:
        # A virtual environment may stand below the root.
        return not is_library(file) and Path(file).is_relative_to(self.root)

    def _location(self, frame: FrameType, line: int) -> Location:
        return Location(self._below_root(frame.f_code.co_filename), line)

    def _below_root(self, file: str) -> str:
        return Path(file).relative_to(self.root).as_posix()


def _one_text(error: BaseException) -> str:
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg}"
    return cut("".join(traceback.format_exception_only(error)).strip())


def _print_traceback(error: BaseException) -> None:
    # The controller may have closed its standard error.
    with contextlib.suppress(OSError, ValueError, AttributeError):
        # A line of it is a line of the source, or the text of an error: that may be endless.
        lines = map(printable, traceback.format_exception(error))
        print("".join(lines), end="", file=sys.stderr)  # noqa: T201 - as Python does
