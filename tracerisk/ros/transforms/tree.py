"""Coordinate frames in time: the tree of transforms that tf2 keeps, with its answers and errors.

A frame has one parent and a history of poses in it, kept for a while, or one pose for ever.
Lookups interpolate between two poses, and never go beyond the first or the last.
Times are integer nanoseconds; time 0 asks for the latest at which all of the way is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

from tracerisk.ros.transforms.history import History, Placed
from tracerisk.ros.transforms.poses import ORIGIN, compose, inverse
from tracerisk.twin.physics.motion import Pose

Failure = Literal["lookup", "connectivity", "extrapolation", "invalid_argument"]

CACHE_NS = 10_000_000_000
"""How long poses are kept by default [ns]."""
_UNIT_TOLERANCE = 1e-2  # of the squared length of a turn; tf2 takes it as 1 within this
_LONGEST_WAY = 1000  # more steps than this to a root are a loop


class FrameError(Exception):
    """A lookup that has no answer; `failure` says why, in tf2's four kinds."""

    def __init__(self, failure: Failure, message: str) -> None:
        super().__init__(message)
        self.failure: Failure = failure


@dataclass(eq=False)
class TransformTree:
    """The frames that are known, with their poses over time."""

    cache_ns: int = CACHE_NS
    """For how long poses are kept [ns]."""
    warn: Callable[[str], None] = lambda _: None
    """The function for a refused pose, with tf2's message."""
    names_span: bool = True
    """Whether the error for an unknown time states the distance to known times (ROS 1)."""
    _names: dict[str, None] = field(default_factory=dict)
    """The names of all frames in the order in which they became known, as keys."""
    _histories: dict[str, History] = field(default_factory=dict)
    """The poses of each frame in its parent, by frame."""
    _authority: dict[str, str] = field(default_factory=dict)
    """The node that last gave the pose of a frame, by frame."""

    @property
    def frames(self) -> tuple[str, ...]:
        """The names of all frames, in the order in which they became known."""
        return tuple(self._names)

    def place(
        self, parent: str, child: str, pose: Pose, stamp_ns: int, authority: str, *, static: bool
    ) -> bool:
        """Note where `child` is in `parent`; return whether it was taken.

        A leading slash of a name is dropped.
        A pose is refused, and `warn` called, that has no name, is its own parent, is not a number,
        turns by a quaternion whose length is not 1, or is older than what is kept.
        """
        parent, child = parent.removeprefix("/"), child.removeprefix("/")
        wrong = _what_is_wrong(parent, child, pose, authority)
        if wrong:
            for message in wrong:
                self.warn(message)
            return False
        self._names.setdefault(child)
        if child not in self._histories:
            self._histories[child] = History(
                self.cache_ns, is_static=static, names_span=self.names_span
            )
        self._names.setdefault(parent)
        refused = self._histories[child].add(Placed(stamp_ns, parent, pose))
        if refused is not None:
            self.warn(
                f"{refused} for frame {child} (parent {parent}) at time {stamp_ns / 1e9:f} "
                f"according to authority {authority}"
            )
            return False
        self._authority[child] = authority
        return True

    def clear(self) -> None:
        """Forget every pose; the names stay known."""
        for history in self._histories.values():
            history.clear()

    def lookup(self, target: str, source: str, time_ns: int) -> tuple[Pose, int]:
        """Return the pose of `source` in `target`, and the time at which it was that [ns].

        Raises:
            FrameError: a frame is not known, the two hang together nowhere, or the time is not
                within what is known.
        """
        if target == source:
            return ORIGIN, time_ns or self._latest_stamp(target)
        self._check("lookupTransform argument target_frame", target)
        self._check("lookupTransform argument source_frame", source)
        return self._walk(target, source, time_ns)

    def way(self, target: str, source: str, time_ns: int) -> list[str]:
        """Return the frames on the way from `source` to `target`.

        Raises:
            FrameError: as `lookup`.
        """
        return self._way(source, target, time_ns)

    def lookup_full(
        self, target: str, target_time_ns: int, source: str, source_time_ns: int, fixed: str
    ) -> tuple[Pose, int]:
        """Return the pose that `source` had at one time in `target` at another, by way of `fixed`.

        Raises:
            FrameError: as `lookup`.
        """
        for role, name in (("target", target), ("source", source), ("fixed", fixed)):
            self._check(f"lookupTransform argument {role}_frame", name)
        into_fixed, _ = self.lookup(fixed, source, source_time_ns)
        into_target, stamp_ns = self.lookup(target, fixed, target_time_ns)
        return compose(into_target, into_fixed), stamp_ns

    def can_transform(self, target: str, source: str, time_ns: int) -> tuple[bool, str]:
        """Return whether `lookup` would answer, and if not why not."""
        if target == source:
            return True, ""
        return self._tried(
            (("target_frame", target), ("source_frame", source)),
            lambda: self._walk(target, source, time_ns),
        )

    def can_transform_full(
        self, target: str, target_time_ns: int, source: str, source_time_ns: int, fixed: str
    ) -> tuple[bool, str]:
        """Return whether `lookup_full` would answer, and if not why not."""
        return self._tried(
            (("target_frame", target), ("source_frame", source), ("fixed_frame", fixed)),
            lambda: self.lookup_full(target, target_time_ns, source, source_time_ns, fixed),
        )

    def latest_common_time(self, target: str, source: str) -> int:
        """Return the latest time at which the whole way is known [ns]; 0 if all of it is static.

        Raises:
            FrameError: a frame is not known, or the two hang together nowhere.
        """
        for role, name in (("target_frame", target), ("source_frame", source)):
            self._check(f"getLatestCommonTime argument {role}", name)
        return self._latest_common_time(target, source)

    def parent(self, frame: str, time_ns: int = 0) -> str | None:
        """Return the parent of a frame at a time, or None."""
        history = self._histories.get(frame)
        placed = history.at(time_ns) if history is not None else None
        return placed.parent if isinstance(placed, Placed) else None

    def chain(
        self, target: str, target_time_ns: int, source: str, source_time_ns: int, fixed: str
    ) -> list[str]:
        """Return the frames on the way from `source` over `fixed` to `target`.

        Raises:
            FrameError: as `lookup`.
        """
        self.lookup_full(target, target_time_ns, source, source_time_ns, fixed)
        first = self._way(source, fixed, source_time_ns)
        second = self._way(fixed, target, target_time_ns)
        return first + second[1:]

    def as_string(self) -> str:
        """Return a sentence for each frame that has a parent."""
        lines = []
        for frame in self._names:
            parent = self.parent(frame)
            if parent is not None:
                lines.append(f"Frame {frame} exists with parent {parent}.\n")
        return "".join(lines)

    def as_yaml(self) -> str:
        """Return parent, authority, rate and times of each frame that has a parent, as YAML."""
        entries = []
        for frame, history in self._histories.items():
            latest, oldest = history.latest, history.oldest
            if latest is None or oldest is None:
                continue
            span_s = (latest.stamp_ns - oldest.stamp_ns) / 1e9
            rate = 10000.0 if span_s == 0.0 else max(history.length / max(span_s, 1e-4), 0.0)
            entries.append(
                f"{frame}: \n"
                f"  parent: '{latest.parent}'\n"
                f"  broadcaster: '{self._authority[frame]}'\n"
                f"  rate: {rate:.3f}\n"
                f"  most_recent_transform: {latest.stamp_ns / 1e9:.3f}\n"
                f"  oldest_transform: {oldest.stamp_ns / 1e9:.3f}\n"
                f"  buffer_length: {span_s:.3f}\n"
            )
        return "".join(entries) or "{}"

    def as_dot(self) -> str:
        """Return the tree as a graph in the DOT language."""
        edges = [
            f'"{parent}" -> "{frame}"[label="Broadcaster: {self._authority[frame]}\\n"];\n'
            for frame in self._names
            if (parent := self.parent(frame)) is not None
        ]
        return "digraph G {\n" + ("".join(edges) or '"no tf data received"') + "}"

    # How a way is found

    def _walk(self, target: str, source: str, time_ns: int) -> tuple[Pose, int]:
        time_ns = time_ns or self._latest_common_time(target, source)
        up, reached, missing = self._ascend(source, target, time_ns)
        if reached == target:
            return up[target], time_ns
        down, _, missing_below = self._ascend(target, source, time_ns)
        common = next((frame for frame in down if frame in up), None)
        if common is not None:
            return compose(inverse(down[common]), up[common]), time_ns
        reason = missing_below or missing
        if reason:
            raise FrameError(
                "extrapolation",
                f"{reason}, when looking up transform from frame [{source}] to frame [{target}]",
            )
        raise self._unconnected(target, source)

    def _ascend(
        self, frame: str, until: str, time_ns: int
    ) -> tuple[dict[str, Pose], str, str | None]:
        """Go from a frame towards its root; return its pose in each ancestor.

        Also the last ancestor reached, and why the way could not be followed further, if so.
        """
        poses = {frame: ORIGIN}
        while frame != until and frame in self._histories:
            placed = self._histories[frame].at(time_ns)
            if isinstance(placed, str):
                return poses, frame, placed
            pose = compose(placed.pose, poses[frame])
            frame = placed.parent
            if frame in poses or len(poses) > _LONGEST_WAY:
                raise self._loop()
            poses[frame] = pose
        return poses, frame, None

    def _way(self, source: str, target: str, time_ns: int) -> list[str]:
        if source == target:
            return [source]
        time_ns = time_ns or self._latest_common_time(target, source)
        up = list(self._ascend(source, target, time_ns)[0])
        if up[-1] == target:
            return up
        down = list(self._ascend(target, source, time_ns)[0])
        common = next(frame for frame in down if frame in up)
        return up[: up.index(common) + 1] + down[: down.index(common)][::-1]

    def _latest_common_time(self, target: str, source: str) -> int:
        if target == source:
            return self._latest_stamp(target)
        up = self._ancestors(source, target)
        down = {target: 0} if target in up else self._ancestors(target, source)
        common = next((frame for frame in down if frame in up), None)
        if common is None:
            raise self._unconnected(target, source)
        # 0 stands for a way that is static: it limits nothing.
        return min((stamp for stamp in (up[common], down[common]) if stamp), default=0)

    def _ancestors(self, frame: str, until: str) -> dict[str, int]:
        """Return the latest time at which the way from a frame to each ancestor is known [ns]."""
        known = {frame: 0}
        while frame != until and frame in self._histories:
            latest = self._histories[frame].latest
            if latest is None:
                break
            so_far = known[frame]
            frame = latest.parent
            if frame in known or len(known) > _LONGEST_WAY:
                raise self._loop()
            known[frame] = min((s for s in (so_far, latest.stamp_ns) if s), default=0)
        return known

    def _latest_stamp(self, frame: str) -> int:
        history = self._histories.get(frame)
        latest = history.latest if history is not None else None
        return 0 if latest is None else latest.stamp_ns

    # What is wrong

    def _check(self, what: str, frame: str) -> None:
        invalid = _invalid_name(what, frame)
        if invalid is not None:
            raise FrameError("invalid_argument", invalid)
        if frame not in self._names:
            raise FrameError("lookup", f'"{frame}" passed to {what} does not exist. ')

    def _tried(
        self, frames: tuple[tuple[str, str], ...], look: Callable[[], object]
    ) -> tuple[bool, str]:
        for role, name in frames:
            invalid = _invalid_name(f"canTransform argument {role}", name)
            if invalid is not None:
                self.warn(invalid)
                return False, ""
        unknown = [
            f"canTransform: {role} {name} does not exist."
            for role, name in frames
            if name not in self._names
        ]
        if unknown:
            return False, " ".join(unknown)
        try:
            look()
        except FrameError as error:
            return False, str(error)
        return True, ""

    def _unconnected(self, target: str, source: str) -> FrameError:
        return FrameError(
            "connectivity",
            f"Could not find a connection between '{target}' and '{source}' because they are "
            f"not part of the same tree.Tf has two or more unconnected trees.",
        )

    def _loop(self) -> FrameError:
        return FrameError(
            "lookup",
            f"The tf tree is invalid because it contains a loop.\n{self.as_string()}\n",
        )


def _what_is_wrong(parent: str, child: str, pose: Pose, authority: str) -> list[str]:
    wrong = []
    if child == parent:
        wrong.append(
            f'TF_SELF_TRANSFORM: Ignoring transform from authority "{authority}" with frame_id '
            f'and child_frame_id  "{child}" because they are the same'
        )
    if not child:
        wrong.append(
            f'TF_NO_CHILD_FRAME_ID: Ignoring transform from authority "{authority}" because '
            f"child_frame_id not set "
        )
    if not parent:
        wrong.append(
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}"  from authority '
            f'"{authority}" because frame_id not set'
        )
    if any(math.isnan(value) for value in (*pose.position, *pose.orientation)):
        wrong.append(
            f'TF_NAN_INPUT: Ignoring transform for child_frame_id "{child}" from authority '
            f'"{authority}" because of a nan value in the transform {_numbers(pose.position)} '
            f"{_numbers(pose.orientation)}"
        )
    elif not abs(sum(value * value for value in pose.orientation) - 1.0) < _UNIT_TOLERANCE:
        wrong.append(
            f'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "{child}" from '
            f'authority "{authority}" because of an invalid quaternion in the transform '
            f"{_numbers(pose.orientation)}"
        )
    return wrong


def _invalid_name(what: str, frame: str) -> str | None:
    if not frame:
        return f"Invalid argument passed to {what} in tf2 frame_ids cannot be empty"
    if frame.startswith("/"):
        return (
            f'Invalid argument "{frame}" passed to {what} in tf2 frame_ids cannot start with '
            f"a '/' like: "
        )
    return None


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + " ".join(f"{value:f}" for value in values) + ")"
