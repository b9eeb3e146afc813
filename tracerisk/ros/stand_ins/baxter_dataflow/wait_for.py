"""Waits for a condition."""

from __future__ import annotations

import errno
from collections.abc import Callable
from typing import Any

import rospy


def wait_for(
    test: Callable[[], Any],
    timeout: float = 1.0,
    raise_on_error: bool = True,
    rate: float = 100,
    timeout_msg: str = "timeout expired",
    body: Callable[[], Any] | None = None,
) -> bool:
    """Wait until a test holds, looking and calling `body` at a rate; return whether it does.

    A timeout below 0 or without end waits for ever.

    Raises:
        OSError: with `raise_on_error`, ROS shuts down (ESHUTDOWN) or time is over (ETIMEDOUT).
    """
    end = rospy.get_time() + timeout
    is_endless = timeout < 0.0 or timeout == float("inf")
    ticks = rospy.Rate(rate)
    while not test():
        failure = None
        if rospy.is_shutdown():
            failure = OSError(errno.ESHUTDOWN, "ROS Shutdown")
        elif not is_endless and rospy.get_time() >= end:
            failure = OSError(errno.ETIMEDOUT, timeout_msg)
        if failure is not None:
            if raise_on_error:
                raise failure
            return False
        if callable(body):
            body()
        ticks.sleep()
    return True
