"""Where the controller's own code stands in a call stack that also holds libraries."""

from __future__ import annotations

import sysconfig
from functools import lru_cache
from pathlib import Path
from sys import _getframe
from types import FrameType

from tracerisk.errors import Location
from tracerisk.instrument.code_positions import qualified_name

_OURS = str(Path(__file__).parents[2]) + "/"
_LIBRARIES = tuple(
    sorted(
        {
            _OURS,
            *(sysconfig.get_path(name) + "/" for name in ("stdlib", "platstdlib")),
            *(sysconfig.get_path(name) + "/" for name in ("purelib", "platlib")),
        }
    )
)

# They read the clock to find the end of a wait, to stamp a record, or to say how long they took:
# no busy wait of theirs. With `qpsolvers`, controllers of their own mink solve inverse kinematics.
_QUIET = frozenset(
    {"asyncio", "concurrent", "logging", "qpsolvers", "queue", "sched", "threading", "tracerisk"}
)
_WAITS = frozenset({"__enter__", "acquire", "wait", "wait_for"})


@lru_cache(maxsize=4096)
def is_library(file: str) -> bool:
    """Return whether a code object's file is tracerisk's, the standard library's or installed."""
    return file.startswith(_LIBRARIES) or file.startswith("<")


def controller_stack(frame: FrameType | None) -> tuple[tuple[Location, str], ...]:
    """Return place and function of each frame of the controller, outermost first."""
    places = []
    while frame is not None:
        if not is_library(frame.f_code.co_filename):
            place = Location(frame.f_code.co_filename, frame.f_lineno)
            places.append((place, qualified_name(frame.f_code, frame.f_globals)))
        frame = frame.f_back
    return tuple(reversed(places))


def library_call(frame: FrameType | None) -> str | None:
    """Return the name of the library function that the controller's innermost frame called.

    Replacements of ours are left out: they stand for functions that the reader knows.
    """
    called = None
    while frame is not None and is_library(frame.f_code.co_filename):
        if not frame.f_code.co_filename.startswith(_OURS):
            called = qualified_name(frame.f_code, frame.f_globals)
        frame = frame.f_back
    return called if frame is not None else None


def controller_frame() -> FrameType | None:
    """Return the controller's innermost frame in the calling thread."""
    frame: FrameType | None = _getframe(1)
    while frame is not None and is_library(frame.f_code.co_filename):
        frame = frame.f_back
    return frame


def caller_beyond(files: tuple[str, ...]) -> FrameType | None:
    """Return the innermost frame beyond the modules whose files end so."""
    frame: FrameType | None = _getframe(1)
    while frame is not None and frame.f_code.co_filename.endswith(files):
        frame = frame.f_back
    return frame


def is_of_tracerisk(frame: FrameType | None) -> bool:
    """Return whether the code of a frame is tracerisk's own."""
    return frame is not None and frame.f_code.co_filename.startswith(_OURS)


def is_quiet(frame: FrameType | None) -> bool:
    """Return whether the frame is a library's whose looks at the clock move nothing."""
    if frame is None:
        return True
    name = str(frame.f_globals.get("__name__", ""))
    if name == "asyncio.base_events" and frame.f_code.co_name == "time":
        # `loop.time()`: what matters is who asks the loop.
        return is_quiet(frame.f_back)
    return name.partition(".")[0] in _QUIET and ".stand_ins" not in name


def poller(frame: FrameType | None) -> FrameType | None:
    """Return who polls a primitive through the waits of `threading`, which are written on it."""
    while (
        frame is not None
        and frame.f_globals.get("__name__") == "threading"
        and frame.f_code.co_name in _WAITS
    ):
        frame = frame.f_back
    return frame
