"""Names of goals that no two goals of a run share."""

from __future__ import annotations

from typing import Any

import rospy
from actionlib_msgs.msg import GoalID

from tracerisk.ros.graph.runtime import Runtime, current
from tracerisk.ros.time.clock import EPOCH_NS


class _GoalCount:
    """How many goal ids the process has made."""

    def __init__(self, runtime: Runtime) -> None:
        del runtime
        self.made = 0


class GoalIDGenerator:
    """Makes goal ids that begin with `name`, by default the node's."""

    def __init__(self, name: str | None = None) -> None:
        self.name = name

    def set_name(self, name: str) -> None:
        """Take the name with which goal ids begin."""
        self.name = name

    def generate_ID(self) -> Any:
        """Return an `actionlib_msgs/GoalID` with the present time as its stamp."""
        run = current()
        count = run.client(_GoalCount)
        count.made += 1
        stamp = rospy.Time(0, EPOCH_NS + run.scheduler.now_ns)
        name = self.name if self.name is not None else rospy.get_name()
        return GoalID(stamp, f"{name}-{count.made}-{stamp.secs}.{stamp.nsecs:09d}")
