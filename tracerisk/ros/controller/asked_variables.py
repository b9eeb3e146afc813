"""Which environment variables a controller asks for that a run does not have."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator, MutableMapping
from sys import _getframe
from types import FrameType
from typing import Any, NoReturn

from tracerisk.ros.controller.frames import is_library

_OF_OTHERS = ("PYTHON", "ROS_", "AMENT_", "CATKIN_", "CMAKE_", "COLCON_", "RMW_", "GAZEBO_", "LC_")
"""How variables begin that Python, ROS and the system read, whose values a run gives or hides."""


@contextlib.contextmanager
def asked_variables(note: Callable[..., object]) -> Iterator[None]:
    """Call `note` with `name`, `file` and `line` of each one, once each place, while this is open.

    Only what the controller's own code asks counts, and no library on its behalf.
    """
    holder: Any = os.environ
    real = holder._data
    known: set[tuple[str, str, int]] = set()

    def missed(key: bytes) -> None:
        name, frame = os.fsdecode(key), _asking(_getframe(2))
        if frame is None or name.startswith(_OF_OTHERS):
            return
        place = (name, frame.f_code.co_filename, frame.f_lineno)
        if place not in known:
            known.add(place)
            note(name=name, file=place[1], line=place[2])

    shared = [item for item in (os.environ, getattr(os, "environb", None)) if item is not None]
    data: MutableMapping[bytes, bytes] = _Variables(missed, real)
    for item in shared:
        vars(item)["_data"] = data
    try:
        yield
    finally:
        real.clear()
        real.update(data)
        for item in shared:
            vars(item)["_data"] = real


class _Variables(dict[bytes, bytes]):
    """The variables of the environment, which say what is missed."""

    def __init__(self, missed: Callable[[bytes], None], values: MutableMapping[bytes, bytes]):
        super().__init__(values)
        self._missed = missed

    def __missing__(self, key: bytes) -> NoReturn:
        self._missed(key)
        raise KeyError(key)


def _asking(frame: FrameType | None) -> FrameType | None:
    """Return the frame that asks, where it is the controller's."""
    while frame is not None and frame.f_code.co_filename.startswith("<"):
        frame = frame.f_back
    return None if frame is None or is_library(frame.f_code.co_filename) else frame
