"""Messages of ROS 1 and of ROS 2 by one set of words: times, durations, which of the two.

A time is `secs` and `nsecs` in ROS 1, `sec` and `nanosec` in a message of ROS 2, and
`nanoseconds` in rclpy's own classes.
"""

from __future__ import annotations

from typing import Any

_S = 1_000_000_000


def is_ros2(message_class: type) -> bool:
    """Return whether a message class is one of ROS 2."""
    return hasattr(message_class, "get_fields_and_field_types")


def nanoseconds(value: Any) -> int:
    """Return a time or a duration of either ROS in nanoseconds.

    Raises:
        TypeError: the value is neither.
    """
    if hasattr(value, "sec") and hasattr(value, "nanosec"):
        return int(value.sec) * _S + int(value.nanosec)
    if hasattr(value, "secs") and hasattr(value, "nsecs"):
        return int(value.secs) * _S + int(value.nsecs)
    if hasattr(value, "nanoseconds"):
        return int(value.nanoseconds)
    raise TypeError(
        f"time must be a Time or a Duration of rospy, rclpy or builtin_interfaces, "
        f"not {type(value).__name__}"
    )


def set_time(value: Any, time_ns: int) -> None:
    """Set the time or duration of a message's field to a length [ns]."""
    seconds, rest = divmod(time_ns, _S)
    if hasattr(value, "nanosec"):
        value.sec, value.nanosec = seconds, rest
    else:
        value.secs, value.nsecs = seconds, rest
