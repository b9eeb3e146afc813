"""What is known of one coordinate frame: its poses in its parent, and those between two of them."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass

from tracerisk.ros.transforms.poses import Quaternion, unit_quaternion
from tracerisk.twin.physics.motion import Pose


@dataclass(frozen=True, slots=True)
class Placed:
    """The pose of a frame at one time."""

    stamp_ns: int
    """The time of the pose [ns]; 0 for a static frame."""
    parent: str
    """The frame that the pose is in."""
    pose: Pose
    """The pose of the frame in its parent."""


class History:
    """What is known of one frame; of a static one, the last pose.

    `names_span`: the error for an unknown time says how far it is from known ones, as in ROS 1.
    """

    def __init__(self, cache_ns: int, *, is_static: bool, names_span: bool = True) -> None:
        self._names_span = names_span
        self.is_static = is_static
        self._cache_ns = cache_ns
        self._stamps: list[int] = []
        self._placed: list[Placed] = []

    @property
    def latest(self) -> Placed | None:
        """The last pose, if there is one."""
        return self._placed[-1] if self._placed else None

    @property
    def oldest(self) -> Placed | None:
        """The first pose that is kept, if there is one."""
        return self._placed[0] if self._placed else None

    @property
    def length(self) -> int:
        """How many poses are kept."""
        return len(self._placed)

    def add(self, placed: Placed) -> str | None:
        """Keep a pose, or return why it is not kept."""
        if self.is_static:
            self._placed = [Placed(0, placed.parent, placed.pose)]
            return None
        if self._stamps and self._stamps[-1] > placed.stamp_ns + self._cache_ns:
            return (
                "TF_OLD_DATA ignoring data from the past (Possible reasons are listed at "
                "http://wiki.ros.org/tf/Errors%20explained)"
            )
        index = bisect_left(self._stamps, placed.stamp_ns)
        if index < len(self._stamps) and self._stamps[index] == placed.stamp_ns:
            return "TF_REPEATED_DATA ignoring data with redundant timestamp"
        self._stamps.insert(index, placed.stamp_ns)
        self._placed.insert(index, placed)
        gone = bisect_left(self._stamps, self._stamps[-1] - self._cache_ns)
        del self._stamps[:gone], self._placed[:gone]
        return None

    def at(self, time_ns: int) -> Placed | str:
        """Return the frame's place at a time, or why it is not known."""
        if not self._placed:
            return "the frame's history is empty"
        if self.is_static or time_ns == 0:
            return self._placed[-1]
        first, last = self._stamps[0], self._stamps[-1]
        if len(self._stamps) == 1 and time_ns != first:
            return (
                f"Lookup would require extrapolation at time {_seconds(time_ns)}, but only time "
                f"{_seconds(first)} is in the buffer"
            )
        if time_ns > last:
            return (
                f"Lookup would require extrapolation {self._span(time_ns - last)}into the future.  "
                f"Requested time {_seconds(time_ns)} but the latest data is at time "
                f"{_seconds(last)}"
            )
        if time_ns < first:
            return (
                f"Lookup would require extrapolation {self._span(first - time_ns)}into the past.  "
                f"Requested time {_seconds(time_ns)} but the earliest data is at time "
                f"{_seconds(first)}"
            )
        index = bisect_right(self._stamps, time_ns) - 1
        before = self._placed[index]
        if before.stamp_ns == time_ns or before.parent != self._placed[index + 1].parent:
            return before
        return _between(before, self._placed[index + 1], time_ns)

    def _span(self, span_ns: int) -> str:
        return f"{_seconds(span_ns)}s " if self._names_span else ""

    def clear(self) -> None:
        """Forget what changes; tf2 keeps what is static."""
        if not self.is_static:
            self._stamps.clear()
            self._placed.clear()


def _between(before: Placed, after: Placed, time_ns: int) -> Placed:
    """Return the place between two: along the line, and along the shorter turn."""
    share = (time_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
    a, b = before.pose.position, after.pose.position
    position = (
        a[0] + share * (b[0] - a[0]),
        a[1] + share * (b[1] - a[1]),
        a[2] + share * (b[2] - a[2]),
    )
    turn = slerp(before.pose.orientation, after.pose.orientation, share)
    return Placed(time_ns, before.parent, Pose(position, turn))


def slerp(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """Return the turn at `share` of the shorter way from `a` to `b` (Shoemake, 1985)."""
    cosine = sum(x * y for x, y in zip(a, b, strict=True))
    sign = math.copysign(1.0, cosine)
    angle = math.acos(min(abs(cosine), 1.0))
    if angle < 1e-6:
        left, right = 1.0 - share, share
    else:
        left = math.sin((1.0 - share) * angle) / math.sin(angle)
        right = math.sin(share * angle) / math.sin(angle)
    return unit_quaternion([left * x + sign * right * y for x, y in zip(a, b, strict=True)])


def _seconds(time_ns: int) -> str:
    return f"{time_ns // 1_000_000_000}.{time_ns % 1_000_000_000:09d}"
