"""Which ROS this run is of, and the times of its client library."""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped

from tracerisk.ros.messages.dialect import is_ros2, nanoseconds

IS_ROS2 = is_ros2(TransformStamped)


def zero_duration() -> Any:
    """Return a duration of length 0, of the run's client library."""
    if IS_ROS2:
        from rclpy.duration import Duration

        return Duration()
    from rospy import Duration as Duration1

    return Duration1(0)


def timeout_ns(timeout: Any) -> int:
    """Return a timeout in nanoseconds; None is none.

    Raises:
        TypeError: it is not a Duration; a number is none to the real library either.
    """
    if timeout is None:
        return 0
    try:
        return nanoseconds(timeout)
    except TypeError:
        raise TypeError(
            f"timeout must be a Duration of {'rclpy' if IS_ROS2 else 'rospy'}, "
            f"not {type(timeout).__name__}"
        ) from None
