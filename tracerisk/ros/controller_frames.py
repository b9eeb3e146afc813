"""Where the controller's own code stands in a call stack that also holds libraries."""

from __future__ import annotations

import sysconfig
from functools import lru_cache
from pathlib import Path
from sys import _getframe
from types import FrameType

from tracerisk.errors import Location

_OURS = str(Path(__file__).parents[1]) + "/"
_LIBRARIES = tuple(
    sorted(
        {
            _OURS,
            *(sysconfig.get_path(name) + "/" for name in ("stdlib", "platstdlib")),
            *(sysconfig.get_path(name) + "/" for name in ("purelib", "platlib")),
        }
    )
)


@lru_cache(maxsize=4096)
def is_library(file: str) -> bool:
    """Tell whether a code object's file is tracerisk's, the standard library's or installed."""
    return file.startswith(_LIBRARIES) or file.startswith("<")


def controller_stack(frame: FrameType | None) -> tuple[tuple[Location, str], ...]:
    """Return place and function of each frame of the controller, outermost first."""
    places = []
    while frame is not None:
        if not is_library(frame.f_code.co_filename):
            place = Location(frame.f_code.co_filename, frame.f_lineno)
            places.append((place, frame.f_code.co_qualname))
        frame = frame.f_back
    return tuple(reversed(places))


def library_call(frame: FrameType | None) -> str | None:
    """Return the name of the library function that the controller's innermost frame called.

    Replacements of ours are left out: they stand for functions that the reader knows.
    """
    called = None
    while frame is not None and is_library(frame.f_code.co_filename):
        if not frame.f_code.co_filename.startswith(_OURS):
            called = frame.f_code.co_qualname
        frame = frame.f_back
    return called if frame is not None else None


def controller_frame() -> FrameType | None:
    """Return the controller's innermost frame in the calling thread."""
    frame: FrameType | None = _getframe(1)
    while frame is not None and is_library(frame.f_code.co_filename):
        frame = frame.f_back
    return frame
