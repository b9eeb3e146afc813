"""Stand-in for message_filters: caches and synchronizers of stamped messages, for both ROS."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any

from std_msgs.msg import Header

from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.messages.dialect import is_ros2, nanoseconds

_IS_ROS2 = is_ros2(Header)
_NO_STAMP = (
    "Cannot use message filters with non-stamped messages. Use the 'allow_headerless' constructor "
    "option to auto-assign ROS time to headerless messages."
)


class SimpleFilter:
    """Something that hands messages on to callbacks."""

    def __init__(self) -> None:
        self.callbacks: dict[int, tuple[Callable[..., object], tuple[Any, ...]]] = {}

    def registerCallback(self, cb: Callable[..., object], *args: Any) -> int:
        """Call `cb` with each output and `args`; return the number of the connection."""
        connection = len(self.callbacks)
        self.callbacks[connection] = (cb, args)
        return connection

    def signalMessage(self, *msg: Any) -> None:
        """Hand messages on."""
        for callback, args in list(self.callbacks.values()):
            callback(*msg, *args)


class Subscriber(SimpleFilter):
    """The messages of a topic.

    The arguments are those of `rospy.Subscriber`; in ROS 2 the node, then those of its
    `create_subscription`.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__()
        if _IS_ROS2:
            self.node = args[0]
            self.topic: Any = args[2]
            kwargs.setdefault("qos_profile", 10)
            self.sub: Any = self.node.create_subscription(*args[1:], self.callback, **kwargs)
            return
        import rospy

        self.topic = args[0]
        kwargs["callback"] = self.callback
        self.sub = rospy.Subscriber(*args, **kwargs)

    def callback(self, msg: Any) -> None:
        """Take a message of the topic."""
        self.signalMessage(msg)

    def getTopic(self) -> str:
        """Return the name of the topic as it was given."""
        return str(self.topic)

    def __getattr__(self, key: str) -> Any:
        # What the subscription has, the filter has; before there is one, nothing.
        if key == "sub":
            raise AttributeError(key)
        return getattr(self.sub, key)


class Cache(SimpleFilter):
    """The last `cache_size` messages of a filter, to be asked for by time."""

    def __init__(self, f: Any, cache_size: int = 1, allow_headerless: bool = False) -> None:
        super().__init__()
        self.cache_size = cache_size
        self.cache_msgs: list[Any] = []
        self.cache_times: list[Any] = []
        self.allow_headerless = allow_headerless
        self.connectInput(f)

    def connectInput(self, f: Any) -> None:
        """Take the messages of a filter."""
        self.incoming_connection = f.registerCallback(self.add)

    def add(self, msg: Any) -> None:
        """Take a message."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            return
        self.cache_times.append(stamp)
        self.cache_msgs.append(msg)
        if len(self.cache_msgs) > self.cache_size:
            del self.cache_msgs[0], self.cache_times[0]
        self.signalMessage(msg)

    def getInterval(self, from_stamp: Any, to_stamp: Any) -> list[Any]:
        """Return the messages between two times, both included."""
        begin, end = nanoseconds(from_stamp), nanoseconds(to_stamp)
        if begin > end:
            raise AssertionError("from_stamp is later than to_stamp")
        return [msg for msg, at in self._timed() if begin <= at <= end]

    def getElemAfterTime(self, stamp: Any) -> Any:
        """Return the oldest message that is not before a time, or None."""
        limit = nanoseconds(stamp)
        return next((msg for msg, at in self._timed() if at >= limit), None)

    def getElemBeforeTime(self, stamp: Any) -> Any:
        """Return the newest message that is not after a time, or None."""
        limit = nanoseconds(stamp)
        return next((msg for msg, at in reversed(self._timed()) if at <= limit), None)

    def getLatestTime(self) -> Any:
        """Return the time of the newest message, or None."""
        return self.cache_times[-1] if self.cache_times else None

    def getLastestTime(self) -> Any:
        """Return what `getLatestTime` does, under the name it once had."""
        return self.getLatestTime()

    def getOldestTime(self) -> Any:
        """Return the time of the oldest message, or None."""
        return self.cache_times[0] if self.cache_times else None

    def getLast(self) -> Any:
        """Return the newest message, or None."""
        return self.getElemAfterTime(self.cache_times[-1]) if self.cache_times else None

    def _timed(self) -> list[tuple[Any, int]]:
        times = (nanoseconds(time) for time in self.cache_times)
        return list(zip(self.cache_msgs, times, strict=True))


class TimeSynchronizer(SimpleFilter):
    """Calls back with one message of each filter, all of the same time.

    Of each filter the latest `queue_size` wait for their partners.
    """

    def __init__(self, fs: Sequence[Any], queue_size: int, reset: bool = False) -> None:
        super().__init__()
        self.queue_size = queue_size
        self.lock = Lock()
        self.enable_reset = reset
        self.connectInput(fs)

    def connectInput(self, fs: Sequence[Any]) -> None:
        """Take the messages of these filters."""
        self.queues: list[dict[int, Any]] = [{} for _ in fs]
        self.input_connections = [
            item.registerCallback(self.add, queue, index)
            for index, (item, queue) in enumerate(zip(fs, self.queues, strict=True))
        ]

    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Take a message for one of the queues."""
        with self.lock:
            stamp = msg.header.stamp
            # Programs also number what belongs together.
            self._put(my_queue, stamp if isinstance(stamp, int) else nanoseconds(stamp), msg)
            for time in sorted(set.intersection(*(set(queue) for queue in self.queues))):
                self._signal([time] * len(self.queues))

    def _put(self, queue: dict[int, Any], time: int, msg: Any) -> None:
        queue[time] = msg
        while len(queue) > self.queue_size:
            del queue[min(queue)]

    def _signal(self, times: Sequence[int]) -> None:
        self.signalMessage(*(queue[time] for queue, time in zip(self.queues, times, strict=True)))
        for queue, time in zip(self.queues, times, strict=True):
            del queue[time]


class ApproximateTimeSynchronizer(TimeSynchronizer):
    """Calls back with one message of each filter, their times less than `slop` apart [s].

    `allow_headerless` takes messages without a stamp as of the time at which they come.
    """

    def __init__(
        self,
        fs: Sequence[Any],
        queue_size: int,
        slop: float,
        allow_headerless: bool = False,
        reset: bool = False,
    ) -> None:
        super().__init__(fs, queue_size, reset)
        self.slop = _duration(slop)
        self.allow_headerless = allow_headerless

    def add(self, msg: Any, my_queue: dict[int, Any], my_queue_index: int | None = None) -> None:
        """Take a message for one of the queues."""
        stamp = _stamp(msg, self.allow_headerless)
        if stamp is None:
            return
        time, slop_ns = nanoseconds(stamp), nanoseconds(self.slop)
        with self.lock:
            self._put(my_queue, time, msg)
            candidates = []
            for index, queue in enumerate(self.queues):
                if index == my_queue_index:
                    candidates.append([time])
                    continue
                near = [number for number in queue if abs(number - time) <= slop_ns]
                candidates.append(sorted(near, key=lambda number: abs(number - time)))
            for times in itertools.product(*candidates):
                known = all(number in q for q, number in zip(self.queues, times, strict=True))
                if known and max(times) - min(times) < slop_ns:
                    self._signal(times)
                    return


def _stamp(msg: Any, allow_headerless: bool) -> Any:
    header: Any = getattr(msg, "header", None)
    stamp = getattr(header, "stamp", None)
    if stamp is not None:
        if not _IS_ROS2:
            return stamp
        from rclpy.time import Time

        return stamp if isinstance(stamp, Time) else Time.from_msg(stamp)
    if _IS_ROS2:
        return _headerless_ros2(allow_headerless)
    import rospy

    if allow_headerless:
        return rospy.Time.now()
    rospy.logwarn(_NO_STAMP)
    return None


def _headerless_ros2(allow_headerless: bool) -> Any:
    import rclpy.clock
    import rclpy.logging

    if allow_headerless:
        return rclpy.clock.ROSClock().now()
    rclpy.logging.get_logger("message_filters_cache").warning(_NO_STAMP)
    return None


def _duration(seconds: float) -> Any:
    if _IS_ROS2:
        from rclpy.duration import Duration

        return Duration(seconds=seconds)
    import rospy

    return rospy.Duration.from_sec(seconds)


__all__ = _defined(globals())
