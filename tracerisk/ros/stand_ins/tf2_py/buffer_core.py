"""The transforms that were set, and lookups among them."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TypeVar

from geometry_msgs.msg import TransformStamped

from tracerisk.common.text.near_names import likely_meant
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.graph.failures import lookup_failed, lookup_succeeded
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.graph.sensor_reading import SensorReading
from tracerisk.ros.messages.dialect import is_ros2, nanoseconds, set_time
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.transforms.tree import CACHE_NS, FrameError, TransformTree
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import WORLD

from .exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
)

_EXCEPTIONS = {
    "connectivity": ConnectivityException,
    "extrapolation": ExtrapolationException,
    "invalid_argument": InvalidArgumentException,
    "lookup": LookupException,
}
Answer = TypeVar("Answer")
_OFTEN = 1000
"""So many looks in vain without a wait in between are those of a busy loop.

A loop of fewer tries ends without the frame, as it does in an instant of a real robot's time.
"""
_AGAIN_NS = 50_000_000
"""How long a busy loop waits that looks for a frame which is not there [ns]."""


def _warn(message: str) -> None:
    print(f"Warning: {message}", file=sys.stderr)  # noqa: T201 - as the real one's console


class BufferCore:
    """Keeps transforms for `cache_time`, 10 s by default, and looks up what follows from them."""

    def __init__(self, cache_time: Any = None) -> None:
        cache_ns = CACHE_NS if cache_time is None else nanoseconds(cache_time)
        self._tree = TransformTree(cache_ns, warn=_warn, names_span=not is_ros2(TransformStamped))
        self._seeker: tuple[object, int] = (None, 0)
        """The thread that looked for an absent frame last, and how often it had waited by then."""
        self._n_vain = 0
        """How often it has looked since then."""

    def set_transform(self, transform: Any, authority: str) -> None:
        """Note a TransformStamped; one that makes no sense is reported and dropped."""
        self._set(transform, authority, static=False)

    def set_transform_static(self, transform: Any, authority: str) -> None:
        """Note a TransformStamped that holds for all times."""
        self._set(transform, authority, static=True)

    def can_transform_core(
        self, target_frame: str, source_frame: str, time: Any
    ) -> tuple[int, str]:
        """Return whether a lookup would be answered, as 1 or 0, and if not why not."""
        self._look(target_frame, source_frame)
        can, why = self._tree.can_transform(target_frame, source_frame, nanoseconds(time))
        return int(can), why

    def can_transform_full_core(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> tuple[int, str]:
        """Return whether a lookup over a fixed frame would be answered, as 1 or 0, and why not."""
        self._look(target_frame, source_frame)
        can, why = self._tree.can_transform_full(
            target_frame,
            nanoseconds(target_time),
            source_frame,
            nanoseconds(source_time),
            fixed_frame,
        )
        return int(can), why

    def lookup_transform_core(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return the transform from source to target at a time, 0 for the latest.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException,
            InvalidArgumentException: there is none.
        """
        self._look(target_frame, source_frame)
        time_ns = nanoseconds(time)
        answer = self._answer(
            (target_frame, source_frame),
            lambda: self._tree.lookup(target_frame, source_frame, time_ns),
        )
        self._read(target_frame, source_frame, time_ns)
        current().client(ReadPoses).read(target_frame, answer[0], source_frame, "a lookup")
        return _stamped(target_frame, source_frame, *answer)

    def lookup_transform_full_core(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> Any:
        """Return the transform from source at one time to target at another.

        Raises:
            LookupException, ConnectivityException, ExtrapolationException,
            InvalidArgumentException: there is none.
        """
        self._look(target_frame, source_frame)
        target_ns, source_ns = nanoseconds(target_time), nanoseconds(source_time)
        answer = self._answer(
            (target_frame, source_frame, fixed_frame),
            lambda: self._tree.lookup_full(
                target_frame, target_ns, source_frame, source_ns, fixed_frame
            ),
        )
        self._read(fixed_frame, source_frame, source_ns)
        self._read(target_frame, fixed_frame, target_ns)
        return _stamped(target_frame, source_frame, *answer)

    def get_latest_common_time(self, target_frame: str, source_frame: str) -> Any:
        """Return the latest time at which the whole way between two frames is known.

        Raises:
            LookupException, ConnectivityException: there is no way.
        """
        self._look(target_frame, source_frame)
        time_ns = self._answer(
            (target_frame, source_frame),
            lambda: self._tree.latest_common_time(target_frame, source_frame),
        )
        return _client_time(time_ns)

    def clear(self) -> None:
        """Forget every transform that is not static."""
        self._tree.clear()

    def all_frames_as_yaml(self) -> str:
        """Return all frames with their parents, rates and times as YAML."""
        return self._tree.as_yaml()

    def all_frames_as_string(self) -> str:
        """Return all frames with their parents as sentences."""
        return self._tree.as_string()

    def _allFramesAsDot(self, time: Any = None) -> str:
        return self._tree.as_dot()

    def _frameExists(self, frame_id: str) -> bool:
        return frame_id in self._tree.frames

    def _getFrameStrings(self) -> list[str]:
        return sorted(self._tree.frames)

    def _chain(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
    ) -> list[str]:
        target_ns, source_ns = nanoseconds(target_time), nanoseconds(source_time)
        return self._answer(
            (target_frame, source_frame, fixed_frame),
            lambda: self._tree.chain(target_frame, target_ns, source_frame, source_ns, fixed_frame),
        )

    def _set(self, transform: Any, authority: str, *, static: bool) -> None:
        turn, shift = transform.transform.rotation, transform.transform.translation
        pose = Pose(
            (float(shift.x), float(shift.y), float(shift.z)),
            (float(turn.x), float(turn.y), float(turn.z), float(turn.w)),
        )
        header = transform.header
        stamp_ns = nanoseconds(header.stamp)
        child = transform.child_frame_id
        self._tree.place(header.frame_id, child, pose, stamp_ns, authority, static=static)

    def _look(self, target: str, source: str) -> None:
        # A loop that asks until there is an answer must see the clock move.
        runtime = current()
        runtime.scheduler.touch()
        robot = None if runtime.twin is None else runtime.twin.robot
        base = WORLD if robot is None else robot.base_link
        names = target.removeprefix("/"), source.removeprefix("/")
        links = () if robot is None else robot.link_names
        known = {*self._tree.frames, WORLD, *links}
        if not known.issuperset(names):
            self._wait_for_frames(runtime.scheduler)
            known = {*self._tree.frames, WORLD, *links}
        parents = names[1] if names[1] in known else base, names[0]
        for name, parent in zip(names, parents, strict=True):
            need = Need("frame", name, parent=parent)
            if name in known or not name:
                runtime.scheduler.needs.meet(need)
            else:
                runtime.scheduler.miss(need)

    def _wait_for_frames(self, scheduler: Scheduler) -> None:
        """Wait a little where a loop looks for an absent frame again and waits for nothing else."""
        thread = scheduler.current
        if thread is None or thread.is_undisturbed:
            return
        is_again = self._seeker == (thread, thread.waits)
        self._n_vain = self._n_vain + 1 if is_again else 0
        if self._n_vain >= _OFTEN:
            count = len(self._tree.frames)
            scheduler.wait_until(
                lambda: len(self._tree.frames) != count,
                timeout_ns=_AGAIN_NS,
                reason="another frame of tf",
            )
        self._seeker = (thread, thread.waits)

    def _read(self, target: str, source: str, time_ns: int) -> None:
        """Note that the transform between two frames comes from the joints between them."""
        runtime = current()
        if runtime.twin is not None:
            way = self._tree.way(target, source, time_ns)
            runtime.client(SensorReading).asked_of_frames(way)

    def _answer(self, names: tuple[str, ...], ask: Callable[[], Answer]) -> Answer:
        try:
            answer = ask()
        except FrameError as error:
            self._report_failed(names, error.failure, str(error))
            raise _EXCEPTIONS[error.failure](str(error)) from None
        lookup_succeeded(names)
        return answer

    def _report_failed(self, names: tuple[str, ...], failure: str, message: str) -> None:
        """Record a look-up in vain under the frame that is missing, else under the source."""
        known = self._tree.frames
        missing = [name for name in names[::-1] if name not in known]
        if missing:
            text = " and ".join(f"'{name}'" for name in sorted(missing))
            meant = [f": {words}" for name in missing if (words := likely_meant(name, known))]
            lookup_failed(f"tf look-up of frame {text} failed{''.join(meant[:1])}", missing[0])
            return
        why = {"connectivity": "nothing connects them", "extrapolation": "not at that time"}
        text = f"tf look-up of frame '{names[1]}' in '{names[0]}' failed"
        lookup_failed(f"{text}: {why.get(failure, message)}", names[1])


def _client_time(time_ns: int) -> Any:
    message = TransformStamped()
    if hasattr(message.header.stamp, "nanosec"):
        from rclpy.time import Time

        return Time(nanoseconds=time_ns)
    from rospy import Time as Time1

    return Time1(0, time_ns)


def _stamped(target: str, source: str, pose: Pose, stamp_ns: int) -> Any:
    message = TransformStamped()
    message.header.frame_id = target
    message.child_frame_id = source
    set_time(message.header.stamp, stamp_ns)
    shift, turn = message.transform.translation, message.transform.rotation
    shift.x, shift.y, shift.z = pose.position
    turn.x, turn.y, turn.z, turn.w = pose.orientation
    return message
