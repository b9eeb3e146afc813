"""Poses that a controller read in one frame and gives back as of another that is elsewhere.

MoveIt takes a bare pose in the reference frame, and `get_current_pose` answers in the planning
frame whatever that is: moveit/moveit
moveit_ros/planning_interface/move_group_interface/src/move_group_interface.cpp.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.transforms.poses import (
    UNIT_LENGTH,
    angle_between,
    compose,
    inverse,
    unit_quaternion,
)
from tracerisk.twin.physics.motion import Pose

_KEPT = 50  # readings that a pose is compared with: a loop reads again and again
_SAME = 1e-7  # numbers that were copied [m]
_APART_M, _APART_RAD = 0.005, 0.02  # frames that differ by less are one for a program
_ROUND_M = 0.005  # what a user adds to a pose is a whole number of these [m]
_TYPED_M = 0.001  # what a user types is a whole number of these [m]


_PLANNING = "the planning frame"
FramePlace = Callable[[str], "Pose | None"]


@dataclass(frozen=True, slots=True)
class _Reading:
    """A pose that the controller has read."""

    frame: str
    """The frame of the pose, without a leading slash."""
    pose: Pose
    """The pose of the link in the frame."""
    link: str
    """The link that it is the pose of, without a leading slash."""
    source: str
    """What gave the pose, in words."""
    place: Location | None
    """The line of the controller that asked; `None` where none is known."""

    @property
    def words(self) -> str:
        """What gave it, and where."""
        line = "" if self.place is None else f" of line {self.place.line}"
        return f"{self.source}{line}"


class ReadPoses:
    """The poses that were read last: `runtime.client(ReadPoses)`."""

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._readings: deque[_Reading] = deque(maxlen=_KEPT)
        self._told: set[tuple[str, Location | None]] = set()

    def read(self, frame: str, pose: Pose, link: str, source: str) -> None:
        """Note that the running code gets the pose of a link; `source` is what gives it."""
        if all(map(math.isfinite, pose.position)):
            plain = frame.lstrip("/")
            self._readings.append(_Reading(plain, pose, link.lstrip("/"), source, asking_place()))

    def given(self, frame: str, pose: Pose, link: str, place_of: FramePlace) -> None:
        """Take a pose that the running code wants a link to have in a frame.

        A finding says where its numbers are those of a pose in a frame that is elsewhere, or of
        another link of the same body; `place_of` returns where a frame or link is, None for one
        that is not known.
        """
        plain = frame.lstrip("/")
        self._look_at_order(pose)
        alike = [one for one in self._readings if _altered(one.pose, pose) is not None]
        there = place_of(plain) if alike else None
        if there is None:
            return
        here = {one.frame: place_of(one.frame) for one in alike}
        same = [one for one in alike if (at := here[one.frame]) is None or not _is_apart(at, there)]
        if same:
            self._look_at_links(same, pose, link, place_of)
            return
        for one in reversed(alike):
            at = here[one.frame]
            assert at is not None
            if _is_unconverted(one.pose, pose, compose(compose(inverse(there), at), one.pose)):
                names = [f"frame '{name}'" if name else _PLANNING for name in (one.frame, plain)]
                self._tell(
                    "other_frame",
                    f"the numbers of this pose are those of {one.words}, which are in {names[0]}, "
                    f"and it is given as of {names[1]}, {_way(at, there)} from there; name the "
                    "frame in its header, or transform it",
                    plain,
                    one,
                )
                return

    def look_at_length(self, turn: Sequence[float]) -> None:
        """Look at the quaternion (x, y, z, w) of an orientation that MoveIt is asked for."""
        length = math.hypot(*turn)
        if abs(length - 1.0) > UNIT_LENGTH:
            shown = ", ".join(f"{value:g}" for value in turn)
            self._tell(
                "unlikely_turn",
                f"the quaternion ({shown}) has length {length:.3g}: MoveIt takes one whose length "
                f"is not 1 within {UNIT_LENGTH:g} for no turn at all",
            )

    def _look_at_links(
        self, same: Sequence[_Reading], pose: Pose, link: str, place_of: FramePlace
    ) -> None:
        """Look at poses that were read in the very frame: of which links they are."""
        if any(one.link == link for one in same):
            return
        for one in reversed(same):
            if not self._are_one_body(one.link, link):
                return
            at, wanted = place_of(one.link), place_of(link)
            if at is None or wanted is None or not _is_apart(at, wanted):
                return
            right = compose(one.pose, compose(inverse(at), wanted))
            # Who takes off the length of a tool along one axis comes nearer to what is right.
            off, was_off = (math.dist(made.position, right.position) for made in (pose, one.pose))
            if off > was_off - _APART_M and _is_unconverted(one.pose, pose, right):
                self._tell(
                    "other_link",
                    f"the numbers of this pose are those of {one.words}, where link '{one.link}' "
                    f"is, and link '{link}' is sent there, {_way(at, wanted)} from it on the same "
                    "body; name the link for which the pose is",
                    link,
                    one,
                )
                return

    def _look_at_order(self, pose: Pose) -> None:
        """Look whether the turn is one that was read, with w before x, y and z."""
        x, y, z, w = pose.orientation
        turn = (y, z, w, x)
        for one in self._readings:
            if (
                _are_alike(turn, one.pose.orientation)
                and not _are_alike(pose.orientation, one.pose.orientation, 1e-3)
                and sum(not _is_whole(value, _TYPED_M) for value in turn) > 1
            ):
                self._tell(
                    "unlikely_turn",
                    f"the quaternion of this pose is that of {one.words} with w first; ROS lists "
                    "x, y, z, w",
                    of=one,
                )
                return

    def _are_one_body(self, link: str, other: str) -> bool:
        above = {
            one.child: one.parent
            for one in self._runtime.twin.robot.attachments
            if one.type == "fixed"
        }

        def body(name: str) -> str:
            while name in above:
                name = above[name]
            return name

        return body(link) == body(other)

    def _tell(self, kind: str, message: str, about: str = "", of: _Reading | None = None) -> None:
        """Record a finding at the line that runs now; `of` is what its message names."""
        place, recorder = asking_place(), self._runtime.recorder
        if recorder is not None and (kind, place) not in self._told:
            self._told.add((kind, place))
            named = [] if of is None or of.place is None else [of.place]
            recorder.finding(kind, message, place, object_name=about, named=named)


def _way(one: Pose, other: Pose) -> str:
    """Return in words how far two places are from one another."""
    far, turned = (
        math.dist(one.position, other.position),
        angle_between(one.orientation, other.orientation),
    )
    parts = [f"{1e3 * far:.0f} mm"] if far > _APART_M else []
    parts += [f"{math.degrees(turned):.0f} degrees"] if turned > _APART_RAD else []
    return " and ".join(parts)


def _altered(read: Pose, given: Pose) -> list[int] | None:
    """Return which coordinates differ; None where these are not the numbers that were read.

    Those have the same turn and a coordinate in common that nobody types.
    """
    turn = unit_quaternion(given.orientation)
    opposite = [-value for value in turn]
    if not (_are_alike(turn, read.orientation) or _are_alike(opposite, read.orientation)):
        return None
    pairs = list(zip(read.position, given.position, strict=True))
    kept = [one for one, other in pairs if abs(one - other) < _SAME]
    if not any(not _is_whole(value, _TYPED_M) for value in kept):
        return None
    return [i for i, (one, other) in enumerate(pairs) if abs(one - other) >= _SAME]


def _is_unconverted(read: Pose, given: Pose, right: Pose) -> bool:
    """Return whether the numbers of a pose cannot come of the right ones, but of those read."""
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


def _are_alike(one: Sequence[float], other: Sequence[float], most: float = _SAME) -> bool:
    """Return whether numbers are the same but for rounding; plain Python, for these are few."""
    return all(
        math.isclose(a, b, rel_tol=1e-5, abs_tol=most) for a, b in zip(one, other, strict=True)
    )


def _is_whole(value: float, step: float) -> bool:
    return abs(value / step - round(value / step)) * step < _SAME


def _is_apart(one: Pose, other: Pose) -> bool:
    far = math.dist(one.position, other.position)
    return far > _APART_M or angle_between(one.orientation, other.orientation) > _APART_RAD
