"""ROS time: `Time` and `Duration` with the clock of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.ros.time import rostime as primitives
from tracerisk.ros.time.clock import EPOCH_NS

from ._node import node
from .exceptions import ROSInitException

if TYPE_CHECKING:
    from typing_extensions import Self


class Duration(primitives.Duration):
    """A span of time in seconds and nanoseconds."""

    __slots__ = ["nsecs", "secs"]

    def __repr__(self) -> str:
        return f"rospy.Duration[{self.to_nsec()}]"


class Time(primitives.Time):
    """A point in time in seconds and nanoseconds since the epoch."""

    __slots__ = ["nsecs", "secs"]

    @staticmethod
    def now() -> Time:
        """Return the current time.

        Raises:
            ROSInitException: the node is not initialized.
        """
        return get_rostime()

    @classmethod
    def from_seconds(cls, float_secs: float) -> Self:
        """Make a time of seconds since the epoch."""
        return cls.from_sec(float_secs)

    def __repr__(self) -> str:
        return f"rospy.Time[{self.to_nsec()}]"


def get_rostime() -> Time:
    """Return the current time.

    Raises:
        ROSInitException: the node is not initialized.
    """
    state = node()
    if not state.is_time_initialized:
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    return Time(0, EPOCH_NS + state.scheduler.read_clock())


def get_time() -> float:
    """Return the current time in seconds since the epoch."""
    return get_rostime().to_sec()


def set_rostime_initialized(val: bool) -> None:
    """Set whether the time may be asked for."""
    node().is_time_initialized = val


def is_rostime_initialized() -> bool:
    """Return whether the time may be asked for."""
    return node().is_time_initialized


def is_wallclock() -> bool:
    """Return whether the time is the machine's: it never is, it is simulated.

    Raises:
        ROSInitException: the node is not initialized.
    """
    if not node().is_time_initialized:
        raise ROSInitException("time is not initialized. Have you called init_node()?")
    return False


def switch_to_wallclock() -> None:
    """Take the time of the machine for that of ROS: in a run both are the simulated one."""
    node().is_time_initialized = True


def wallsleep(duration: float) -> None:
    """Sleep for seconds; on the simulated clock, as everything does."""
    node().scheduler.sleep(round(duration * 1e9))


def duration_ns(duration: float | primitives.Duration) -> int:
    """Return a length of time, given as seconds or a Duration, in nanoseconds."""
    if isinstance(duration, primitives.Duration):
        return duration.to_nsec()
    return round(duration * 1_000_000_000)
