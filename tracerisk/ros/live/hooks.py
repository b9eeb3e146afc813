"""What the hooks in a controller's client library report, in either version of ROS.

Nothing is changed of what is sent: each hook calls what was there, and waits on the wall clock take
time of the twin.
"""

from __future__ import annotations

import hashlib
import inspect
import math
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import Location
from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.marks.caught_exceptions import QUESTIONS, REFUSED, STAND_INS
from tracerisk.instrument.tracer import Frame, Tracer
from tracerisk.ros.graph.failures import CALLBACK_FAILED, ERROR_LOGGED, plain_line


class Report(Protocol):
    """Passes a header on to the twin's side, with the bytes that belong to it."""

    def __call__(self, header: dict[str, Any], body: bytes = b"") -> None:
        """Pass them on."""


def digest(body: bytes) -> str:
    """Return what stands for the bytes of a message."""
    return hashlib.blake2b(body, digest_size=16).hexdigest()


def frames_data(stack: tuple[Frame, ...]) -> list[list[Any]]:
    """Return a stack as JSON data; `frames_of` reads it."""
    return [
        [
            *(frame.function.file, frame.function.name, frame.line, frame.activation),
            *(list(frame.site), frame.root, frame.instance, frame.through),
        ]
        for frame in stack
    ]


def frames_of(data: list[list[Any]]) -> tuple[Frame, ...]:
    """Read what `frames_data` made of a stack."""
    return tuple(
        Frame(
            FunctionRef(str(file), QualifiedName(str(name))),
            int(line),
            int(activation),
            (int(site[0]), int(site[1])),
            root,
            instance,
            tuple((str(place), (int(at[0]), int(at[1]))) for place, at in through),
        )
        for file, name, line, activation, site, root, instance, through in data
    )


def sent(stack: tuple[Frame, ...], **what: Any) -> dict[str, Any]:
    """Return the header that says which functions send what is described."""
    thread = threading.get_ident()
    return {"is": "sent", "stack": frames_data(stack), "thread": thread, **what}


def threads_inherit(tracer: Tracer) -> None:
    """Give each thread the stack of the code that starts it."""
    real = threading.Thread.start

    @hide
    def start(self: threading.Thread) -> None:
        captured = tracer.capture()
        run = self.run

        @hide
        def traced() -> None:
            with tracer.resume(captured):
                run()

        if captured.frames:
            self.run = traced  # type: ignore[method-assign]
        real(self)

    threading.Thread.start = start  # type: ignore[method-assign]


def sleeps_take_simulated_time(tracer: Tracer, wait: Callable[[float], None]) -> None:
    """Make the controller's own `time.sleep` call `wait`; libraries sleep as ever."""
    real = time.sleep

    @hide
    def sleep(seconds: Any, /) -> None:
        is_own = tracer.is_controllers(sys._getframe(1))
        if is_own and isinstance(seconds, int | float) and 0 < seconds < math.inf:
            wait(seconds)
        else:
            real(seconds)  # says what is wrong with a length that is none

    time.sleep = sleep


class Failures:
    """Reports what fails in the controller's code and with which the library goes on.

    `library` is where the client library's packages lie, `between` the packages and modules between
    the controller's call that logs and what takes the line.
    """

    between: tuple[str, ...] = ()

    def __init__(self, tracer: Tracer, report: Report, library: Path) -> None:
        self.tracer, self._report, self._library = tracer, report, library

    def watch(self) -> None:
        """Report threads that die, lines of the log that are errors, and calls refused in vain."""
        replaced = {path.name for path in Path(STAND_INS[0], "stand_ins").iterdir()} - QUESTIONS
        self.tracer.ros_libraries = tuple(f"{self._library}/{name}/" for name in sorted(replaced))
        self.tracer.on_caught = lambda failure: self.tell(
            REFUSED, failure.words, failure.location, failure.call
        )
        real = threading.excepthook

        def notify(failure: threading.ExceptHookArgs) -> None:
            error, thread = failure.exc_value, failure.thread
            if error is not None and not isinstance(error, SystemExit) and self.counts(error):
                name = "" if thread is None else f" {thread.name}"
                words = f"thread{name} died of {_words(error)}, and the controller went on"
                self.tell("thread_failed", words, self.tracer.where_failed(error))
            real(failure)

        threading.excepthook = notify

    def logged(self, text: str, *, is_fatal: bool) -> None:
        """Report a line of the log that is an error, if the controller's own code wrote it."""
        frame = sys._getframe(1)
        while frame.f_back is not None and _is_of(frame, self.between):
            frame = frame.f_back
        if not self.tracer.is_controllers(frame):
            return
        first = (text.strip().splitlines() or [""])[0]
        words = f"it logged {'FATAL' if is_fatal else 'ERROR'}: {first}"
        self.tell(ERROR_LOGGED, words, self.tracer.where(), plain_line(first))

    def of_callback(self, what: str, error: Exception) -> None:
        """Report that a callback raised an error with which the library goes on."""
        if self.counts(error):
            words = f"{what} raised {type(error).__name__}: {error}"
            place = self.tracer.where_failed(error)
            self.tell(CALLBACK_FAILED, words, place, type(error).__name__)

    def counts(self, error: BaseException) -> bool:  # noqa: ARG002
        """Return whether an error is one, and not the way in which the library ends."""
        return True

    def tell(self, kind: str, message: str, place: Location | None, about: str = "") -> None:
        """Report a failure of a kind, where it was, and what it is about."""
        data = None if place is None else [place.file, place.line, place.column]
        self._report(
            {"is": "failed", "kind": kind, "message": message, "location": data, "object": about}
        )


def _is_of(frame: FrameType, modules: tuple[str, ...]) -> bool:
    """Return whether the code of a frame is that of a module, or of one below it."""
    name = str(frame.f_globals.get("__name__", ""))
    return any(f"{name}.".startswith(f"{module}.") for module in modules)


def _words(error: BaseException) -> str:
    return " ".join("".join(traceback.format_exception_only(error)).split())


def watched(callback: Any, failed: Callable[[Exception], None]) -> Any:
    """Return `callback`, a function or a coroutine's, such that `failed` gets what it raises."""

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            return callback(*args, **kwargs)
        except Exception as error:
            failed(error)
            raise

    @hide
    async def awaited(*args: Any, **kwargs: Any) -> Any:
        try:
            return await callback(*args, **kwargs)
        except Exception as error:
            failed(error)
            raise

    return awaited if inspect.iscoroutinefunction(callback) else called
