"""The process in which a controller runs: the twin, the stand-ins, the tracer and its end.

Started by `tracerisk.pipeline` as `python -m tracerisk.pipeline.child REQUEST`; what it finds it
writes into the folder of the recording at once, so that a sudden death loses nothing seen.
"""

from __future__ import annotations

import builtins
import contextlib
import ctypes
import dataclasses
import faulthandler
import io
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType, TracebackType

from tracerisk.errors import ExitCode, Location, TraceRiskError
from tracerisk.instrument.loader import prepared_controller
from tracerisk.instrument.recording import Recorder
from tracerisk.instrument.tracer import Tracer
from tracerisk.pipeline.run_files import EVENTS, STACKS, RunRequest, WallTime
from tracerisk.ros.finder import StandInFinder
from tracerisk.ros.graph import Graph
from tracerisk.ros.patches import virtual_time
from tracerisk.ros.runtime import Runtime, activate
from tracerisk.ros.virtual_time import RunOver, Scheduler
from tracerisk.trace import EndCause
from tracerisk.twin.robot import load_robot
from tracerisk.twin.samples import SampleWriter
from tracerisk.twin.scene import load_scene
from tracerisk.twin.twin import Twin

_MB = 1024 * 1024


def main() -> int:
    """Run the request named on the command line; the exit code says how the run ended."""
    request = RunRequest.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    _apply_limits(request.memory_limit_mb)
    folder = Path(request.folder)
    with (folder / STACKS).open("w") as stacks:
        # The parent asks where an endless loop stands before it ends the process.
        faulthandler.register(signal.SIGUSR1, file=stacks, all_threads=True)
        return _run(request, folder)


def _apply_limits(memory_limit_mb: int) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = memory_limit_mb * _MB
    limit = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    if sys.platform == "linux":
        # A parent that is killed takes the controller with it.
        death_signal = 1
        ctypes.CDLL(None).prctl(death_signal, signal.SIGKILL)


def _run(request: RunRequest, folder: Path) -> int:
    script = Path(request.controller)
    # Bound before virtual time takes the place of the machine's.
    wall_clock = time.perf_counter
    with (
        (folder / EVENTS).open("wb", buffering=0) as stream,
        SampleWriter(folder) as samples,
    ):
        twin = Twin.build(load_robot(request.robot), load_scene(request.scene), samples=samples)
        # The recorder's clock and the tracer know each other only through the scheduler.
        clock: list[Callable[[], int]] = [lambda: 0]
        recorder = Recorder(stream, clock=lambda: clock[0]())
        tracer = Tracer(recorder.function_ran)
        world = _Metered(twin, wall_clock)
        scheduler = Scheduler(
            world,
            duration_ns=round(request.duration_s * 1e9),
            tracer=tracer,
            on_stuck=lambda over: _end_now(recorder, over),
        )
        clock[0] = lambda: scheduler.now_ns
        runtime = Runtime(
            scheduler,
            Graph(scheduler, tracer),
            twin=twin,
            tracer=tracer,
            recorder=recorder,
            argv=(str(script), *request.argv),
            seed=request.seed,
        )
        end = _End(recorder, twin, Path(request.root))
        with (
            activate(runtime),
            StandInFinder(),
            virtual_time(scheduler),
            _scripted_input(request.answers, recorder),
            _exit_watched(end),
        ):
            try:
                with prepared_controller(
                    script, tracer, request.argv, root=Path(request.root)
                ) as run:
                    began = wall_clock()
                    _run_to_the_end(lambda: scheduler.run_main(run), end)
                    twin.close()
                    WallTime(wall_clock() - began, world.seconds).write(folder)
                    return 0
            except TraceRiskError as error:
                # Nothing has run: the source itself is at fault.
                end.failed(error)
                return int(error.exit_code)


class _Metered:
    """The twin as the scheduler's world, with the wall time that its steps take [s]."""

    def __init__(self, twin: Twin, wall_clock: Callable[[], float]) -> None:
        self._twin = twin
        self._wall_clock = wall_clock
        self.seconds = 0.0

    @property
    def time_ns(self) -> int:
        return self._twin.time_ns

    @property
    def busy(self) -> bool:
        return self._twin.busy

    def advance(self, until_ns: int) -> int:
        began = self._wall_clock()
        try:
            return self._twin.advance(until_ns)
        finally:
            self.seconds += self._wall_clock() - began


def _run_to_the_end(run: Callable[[], None], end: _End) -> None:
    try:
        run()
    except RunOver as over:
        end.tell(over.cause, over.message, over.location)
    except SystemExit as error:
        end.exited(error)
    except MemoryError as error:
        end.raised(error, "memory_limit")
    except BaseException as error:  # noqa: BLE001 - here the controller ends
        end.raised(error, "raised")
    else:
        end.tell("ended", "the controller ended")


class _End:
    """Tells the recording how the run ended, once."""

    def __init__(self, recorder: Recorder, twin: Twin, root: Path) -> None:
        self._recorder = recorder
        self._twin = twin
        self._root = root
        self._told = False

    def tell(self, cause: EndCause, message: str, location: Location | None = None) -> None:
        if self._told:
            return
        self._told = True
        self._recorder.note(
            "objects", found=[dataclasses.asdict(each) for each in self._twin.object_offsets()]
        )
        self._recorder.run_ended(cause, message, location)

    def failed(self, error: TraceRiskError) -> None:
        place = error.location
        self._recorder.note(
            "failed",
            error=type(error).__name__,
            message=error.message,
            location=None if place is None else [place.file, place.line, place.column],
        )

    def exited(self, error: SystemExit) -> None:
        code = error.code
        if code in (None, 0):
            self.tell("ended", "the controller ended")
            return
        place = self._innermost(error.__traceback__)
        if isinstance(code, int):
            self.tell("exited", f"the controller exited with code {code}", place)
        else:
            self.tell("exited", f"the controller exited: {code}", place)

    def raised(self, error: BaseException, cause: EndCause) -> None:
        traceback.print_exception(error)
        text = "".join(traceback.format_exception_only(error)).strip()
        if isinstance(error, SyntaxError):
            text = f"{type(error).__name__}: {error.msg}"
        self.tell(cause, f"the controller raised {text}", self._innermost(error.__traceback__))

    def exited_at_once(self, code: int, frame: FrameType | None) -> None:
        while frame is not None and not self._is_controllers(frame):
            frame = frame.f_back
        place = None if frame is None else self._location(frame, frame.f_lineno)
        if code == 0:
            self.tell("ended", "the controller ended by os._exit(0)", place)
        else:
            self.tell("exited", f"the controller called os._exit({code})", place)

    def _innermost(self, trace: TracebackType | None) -> Location | None:
        place = None
        while trace is not None:
            if self._is_controllers(trace.tb_frame):
                place = self._location(trace.tb_frame, trace.tb_lineno)
            trace = trace.tb_next
        return place

    def _is_controllers(self, frame: FrameType) -> bool:
        return Path(frame.f_code.co_filename).is_relative_to(self._root)

    def _location(self, frame: FrameType, line: int) -> Location:
        file = Path(frame.f_code.co_filename).relative_to(self._root).as_posix()
        return Location(file, line)


def _end_now(recorder: Recorder, over: RunOver) -> None:
    recorder.run_ended(over.cause, over.message, over.location)
    os.kill(os.getpid(), signal.SIGKILL)


@contextlib.contextmanager
def _exit_watched(end: _End) -> Iterator[None]:
    """Let `os._exit` tell where it was called before it ends the process."""
    real = os._exit

    def told(status: int) -> None:
        if os.getpid() == owner:
            end.exited_at_once(status, sys._getframe(1))
        real(status)

    owner = os.getpid()
    os._exit = told  # type: ignore[assignment]
    try:
        yield
    finally:
        os._exit = real


@contextlib.contextmanager
def _scripted_input(answers: tuple[str, ...], recorder: Recorder) -> Iterator[None]:
    """Give `input()` and reads of the standard input the answers in turn, then Enter."""
    stream = _Answers(answers, recorder)
    real_input, real_stdin = builtins.input, sys.stdin

    def scripted(prompt: object = "", /) -> str:
        print(prompt, end="", flush=True)  # noqa: T201 - the controller's own output
        return stream.readline().rstrip("\n")

    builtins.input, sys.stdin = scripted, stream
    try:
        yield
    finally:
        builtins.input, sys.stdin = real_input, real_stdin


class _Answers(io.TextIOBase):
    """A standard input that says the answers line by line, then empty lines."""

    def __init__(self, answers: tuple[str, ...], recorder: Recorder) -> None:
        self._answers = list(answers)
        self._recorder = recorder

    def readable(self) -> bool:
        return True

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]  # noqa: ARG002
        answer = self._answers.pop(0) if self._answers else ""
        self._recorder.note("input", answer=answer)
        return f"{answer}\n"

    def read(self, size: int | None = -1, /) -> str:  # noqa: ARG002
        return self.readline()


if __name__ == "__main__":
    try:
        code = main()
    except TraceRiskError as problem:
        print(problem, file=sys.stderr)  # noqa: T201 - it has no other mouth
        code = int(problem.exit_code)
    except MemoryError:
        code = int(ExitCode.CONTROLLER_FAILED)
    sys.stdout.flush()
    sys.exit(code)
