"""Record what fails in a controller: look-ups, callbacks, lines of the log that are errors."""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import FrameType, TracebackType
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import caller_beyond, controller_frame, is_library
from tracerisk.ros.controller.removed_names import removed_name_hint
from tracerisk.ros.graph.runtime import current, running

CALLBACK_FAILED = "callback_failed"
ERROR_LOGGED = "error_logged"
LOOKUP_FAILED = "lookup_failure"

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?", re.IGNORECASE)
_LONGEST = 80
_LOGGING = (__file__, "/rclpy/_logger.py", "/rospy/core.py")


def lookup_failed(message: str, frame_name: str) -> None:
    """Record that the controller's code that runs looked up a frame in vain."""
    recorder, frame = _recorder(), controller_frame()
    if recorder is not None and frame is not None:
        recorder.failed(
            LOOKUP_FAILED,
            message,
            _place(frame),
            asker=_asker(frame),
            object_name=frame_name,
        )


def lookup_succeeded(frame_names: Sequence[str]) -> None:
    """Record that the code that runs found the way between frames."""
    recorder = _recorder()
    if recorder is None or not recorder.has_open_failures:
        return
    frame = controller_frame()
    if frame is not None:
        for name in frame_names:
            recorder.succeeded(LOOKUP_FAILED, asker=_asker(frame), object_name=name)


def callback_failed(what: str, error: BaseException) -> None:
    """Record that a callback raised an error with which the library goes on."""
    recorder = _recorder()
    current().scheduler.needs.note_error(str(error))
    if recorder is not None:
        hint = removed_name_hint(error)
        message = f"{what} raised {type(error).__name__}: {error}" + (f"; {hint}" if hint else "")
        place = error_place(error.__traceback__)
        recorder.finding(CALLBACK_FAILED, message, place, object_name=type(error).__name__)


def trouble_logged(severity: str, text: str) -> None:
    """Record a line of the log of severity WARN or above, if the controller's own code wrote it.

    ERROR and FATAL are a finding, whose object is the line with each number as `#`, for
    acceptances.
    """
    recorder, frame = _recorder(), caller_beyond(_LOGGING)
    if recorder is None or frame is None or is_library(frame.f_code.co_filename):
        return
    first = (text.strip().splitlines() or [""])[0]
    recorder.sign("log", plain_line(first))
    if severity.startswith("WARN"):
        return
    current().scheduler.needs.note_error(first)
    recorder.failed(
        ERROR_LOGGED,
        f"it logged {severity}: {first}",
        _place(frame),
        asker=_asker(frame),
        object_name=plain_line(first),
    )


def answer_failed(
    name: str, answer: Any, stack: Sequence[Any] | None = None, *, has_failed: bool = False
) -> None:
    """Record the answer of an action or a service where it is a failure.

    `stack` is that of the code that asked, by default of the code that runs; `has_failed` says that
    its status is a failure, else its fields say so.
    """
    runtime = running()
    if runtime is None or runtime.beside is not None or runtime.recorder is None:
        return
    code = getattr(answer, "error_code", 0)
    code = getattr(code, "val", code)  # that of MoveIt is 1 for a success
    is_code = has_failed or code not in (0, 1, "", None)
    says_no = any(getattr(answer, field, True) is False for field in ("success", "reached_goal"))
    if is_code or says_no:
        tracer: Any = runtime.tracer
        if stack is None:
            stack = () if tracer is None else tracer.stack()
        runtime.recorder.sign("code" if is_code else "result", name, stack)


def plain_line(text: str) -> str:
    """Return a line of a log in which what varies from run to run is left out: its numbers."""
    return _NUMBER.sub("#", text)[:_LONGEST]


def error_place(trace: TracebackType | None) -> Location | None:
    """Return the innermost place of the controller's code in a traceback."""
    place = None
    while trace is not None:
        if not is_library(trace.tb_frame.f_code.co_filename):
            place = Location(trace.tb_frame.f_code.co_filename, trace.tb_lineno)
        trace = trace.tb_next
    return place


def _recorder() -> Any:
    """Return where failures of the controller go; `None` in the code of a companion."""
    runtime = current()
    return None if runtime.beside is not None else runtime.recorder


def _place(frame: FrameType) -> Location:
    return Location(frame.f_code.co_filename, frame.f_lineno)


def _asker(frame: FrameType) -> tuple[str, int]:
    return frame.f_code.co_filename, frame.f_code.co_firstlineno
