"""Euler angles that seem to be degrees where radians are taken."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import Runtime, current

_STEP = 0.5  # users give degrees in whole numbers of this


class EulerAngles:
    """The lines that gave angles which may be degrees: `runtime.client(EulerAngles)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._told: set[Location | None] = set()

    def look_at(self, angles: Sequence[float], name: str) -> None:
        """Note angles that the running code gives to `name`, which takes [rad], if unlikely.

        Such are of more than a turn, all of them in whole or half numbers.
        """
        given = [float(angle) for angle in angles]
        place = asking_place()
        recorder = self._runtime.recorder
        if recorder is None or place in self._told or not _are_degrees(given):
            return
        self._told.add(place)
        shown = ", ".join(f"{angle:g}" for angle in given)
        turns = max(map(abs, given)) / math.tau
        recorder.finding(
            "unlikely_unit",
            f"{name} takes radians: ({shown}) (degrees?) is up to {turns:.1f} whole turns",
            place,
            object_name=name,
        )


def _are_degrees(angles: Sequence[float]) -> bool:
    return (
        all(map(math.isfinite, angles))
        and max(map(abs, angles), default=0.0) > 2 * math.pi
        and all((angle / _STEP).is_integer() for angle in angles)
    )


def look_at_euler(angles: Sequence[float], name: str) -> None:
    """Look at angles as `EulerAngles` does, in a run; outside of one do nothing."""
    try:
        runtime = current()
    except RuntimeError:
        return
    runtime.client(EulerAngles).look_at(angles, name)
