"""The clocks of a controller's rclpy, whose time comes over the link."""

from __future__ import annotations

import importlib
import threading
import weakref
from typing import Any

from tracerisk.instrument.hidden_frames import hide


class Clocks:
    """Sets the time of all clocks of ROS that nodes of this process have."""

    def __init__(self) -> None:
        sources: Any = importlib.import_module("rclpy.time_source")
        clocks: Any = importlib.import_module("rclpy.clock")
        self._time: Any = importlib.import_module("rclpy.time").Time
        self._kind = importlib.import_module("rclpy.clock").ClockType.ROS_TIME
        self._clocks: weakref.WeakSet[Any] = weakref.WeakSet()
        self._now = self._time(clock_type=self._kind)
        self._now_ns = 0
        self._ticked = threading.Condition()
        kind = sources.TimeSource
        real_attach, real_active = kind.attach_clock, clocks.ROSClock._set_ros_time_is_active
        known = self._clocks

        @hide
        def attach_clock(source: Any, clock: Any) -> None:
            source._last_time_set = self._now
            real_attach(source, clock)
            real_active(clock, enabled=True)
            known.add(clock)

        kind.attach_clock = attach_clock
        # A node that uses simulated time subscribes to it, and has it already.
        kind.clock_callback = lambda source, message: None  # noqa: ARG005
        clocks.ROSClock._set_ros_time_is_active = lambda clock, enabled: real_active(  # noqa: ARG005
            clock, enabled=True
        )

    def set(self, now_ns: int) -> None:
        """Set the time [ns]."""
        with self._ticked:
            self._now_ns = now_ns
            self._ticked.notify_all()
        self._now = self._time(nanoseconds=now_ns, clock_type=self._kind)
        for clock in list(self._clocks):
            try:
                clock.set_ros_time_override(self._now)
            except Exception:  # noqa: BLE001 - its node has been destroyed
                self._clocks.discard(clock)

    def wait(self, seconds: float) -> None:
        """Wait for some time of the twin [s], from its first on."""
        with self._ticked:
            self._ticked.wait_for(lambda: self._now_ns > 0)
            until_ns = self._now_ns + round(seconds * 1e9)
            self._ticked.wait_for(lambda: self._now_ns >= until_ns)
