"""The primitives `time` and `duration`."""

from tracerisk.ros.time.rostime import Duration, Time, TVal

__all__ = ["Duration", "TVal", "Time"]
