"""The kinds of clocks."""

from enum import IntEnum


class ClockType(IntEnum):
    """What a clock counts; all of them read the simulated time."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3
