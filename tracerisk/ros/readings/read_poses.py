"""Poses that a controller read in one frame and gives back as of another that is elsewhere.

MoveIt takes a bare pose in the reference frame, and `get_current_pose` answers in the planning
frame whatever that is: moveit/moveit
moveit_ros/planning_interface/move_group_interface/src/move_group_interface.cpp.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.transforms.poses import angle_between, compose, inverse, unit_quaternion
from tracerisk.twin.physics.motion import Pose

_KEPT = 50  # readings that a pose is compared with: a loop reads again and again
_SAME = 1e-7  # numbers that were copied [m]
_APART_M, _APART_RAD = 0.005, 0.02  # frames that differ by less are one for a program
_ROUND_M = 0.005  # what a person adds to a pose is a whole number of these [m]
_TYPED_M = 0.001  # what a person types is a whole number of these [m]


FramePlace = Callable[[str], "Pose | None"]


@dataclass(frozen=True, slots=True)
class _Reading:
    """A pose that was read: its frame, what gave it and the line that asked."""

    frame: str
    pose: Pose
    source: str
    place: Location | None


class ReadPoses:
    """The poses that were read last: `runtime.client(ReadPoses)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._readings: deque[_Reading] = deque(maxlen=_KEPT)
        self._told: set[Location | None] = set()

    def read(self, frame: str, pose: Pose, source: str) -> None:
        """Note that the running code gets a pose in a frame; `source` is what gives it."""
        if not all(map(math.isfinite, pose.position)):
            return
        self._readings.append(_Reading(frame.lstrip("/"), pose, source, asking_place()))

    def given(self, frame: str, pose: Pose, place_of: FramePlace) -> None:
        """Take a pose that the running code gives as of a frame.

        A finding says where its numbers are those of a pose in a frame that is elsewhere;
        `place_of` returns where a frame is, None for one that is not known.
        """
        plain = frame.lstrip("/")
        alike = [one for one in self._readings if _altered(one.pose, pose) is not None]
        if not alike or any(one.frame == plain for one in alike):
            return
        there = place_of(plain)
        if there is None:
            return
        for one in reversed(alike):
            here = place_of(one.frame)
            if here is None or not _is_apart(here, there):
                return
            if not _is_unconverted(one.pose, pose, compose(inverse(there), here)):
                continue
            self._tell(one, plain, here, there)
            return

    def _tell(self, one: _Reading, frame: str, here: Pose, there: Pose) -> None:
        place = asking_place()
        if place in self._told:
            return
        self._told.add(place)
        far = 1e3 * math.dist(here.position, there.position)
        turned = math.degrees(angle_between(here.orientation, there.orientation))
        apart = " and ".join(
            [f"{far:.0f} mm" for _ in range(far > 1e3 * _APART_M)]
            + [f"{turned:.0f} degrees" for _ in range(turned > math.degrees(_APART_RAD))]
        )
        line = f" of line {one.place.line}" if one.place is not None else ""
        names = [f"frame '{name}'" if name else "the planning frame" for name in (one.frame, frame)]
        self._runtime.recorder.finding(
            "other_frame",
            f"the numbers of this pose are those of {one.source}{line}, which are in {names[0]}, "
            f"and it is given as of {names[1]}, {apart} from there; name the frame in its header, "
            "or transform it",
            place,
            object_name=frame,
        )


def _altered(read: Pose, given: Pose) -> list[int] | None:
    """Return which coordinates differ; None where these are not the numbers that were read.

    Those have the same turn and a coordinate in common that nobody types.
    """
    turn = unit_quaternion(given.orientation)
    if not np.allclose(turn, read.orientation, atol=_SAME) and not np.allclose(
        np.negative(turn), read.orientation, atol=_SAME
    ):
        return None
    pairs = list(zip(read.position, given.position, strict=True))
    kept = [one for one, other in pairs if abs(one - other) < _SAME]
    if not any(not _is_whole(value, _TYPED_M) for value in kept):
        return None
    return [i for i, (one, other) in enumerate(pairs) if abs(one - other) >= _SAME]


def _is_unconverted(read: Pose, given: Pose, from_read: Pose) -> bool:
    """Return whether the numbers of a pose cannot be what the way between the frames makes."""
    right = compose(from_read, read)
    if angle_between(right.orientation, read.orientation) > _APART_RAD:
        return True
    shifts = [there - here for here, there in zip(read.position, right.position, strict=True)]
    altered = _altered(read, given) or []
    if any(abs(shift) > _APART_M for i, shift in enumerate(shifts) if i not in altered):
        return True
    # What was added is round, and what would have been added to the right numbers is not.
    added = [given.position[i] - read.position[i] for i in altered]
    return (
        bool(altered)
        and all(_is_whole(value, _ROUND_M) for value in added)
        and any(
            not _is_whole(value - shifts[i], _ROUND_M)
            for i, value in zip(altered, added, strict=True)
        )
    )


def _is_whole(value: float, step: float) -> bool:
    return abs(value / step - round(value / step)) * step < _SAME


def _is_apart(one: Pose, other: Pose) -> bool:
    far = math.dist(one.position, other.position)
    return far > _APART_M or angle_between(one.orientation, other.orientation) > _APART_RAD
