"""What a server of actions keeps of a goal."""

from __future__ import annotations

from typing import Any

import rospy
from actionlib_msgs.msg import GoalStatus

from .goal_id_generator import GoalIDGenerator


class StatusTracker:
    """The status of a goal: of a message with a goal, or of an identifier and a status."""

    def __init__(self, goal_id: Any = None, status: int | None = None, goal: Any = None) -> None:
        self.goal = goal
        self.handle_tracker: Any = None
        self.handle_destruction_time = rospy.Time()
        self.id_generator = GoalIDGenerator()
        self.status = GoalStatus()
        if goal_id:
            self.status.goal_id = goal_id
            self.status.status = status
        if goal is None:
            return
        self.status.goal_id = goal.goal_id
        self.status.status = GoalStatus.PENDING
        if not self.status.goal_id.id:
            self.status.goal_id = self.id_generator.generate_ID()
        if self.status.goal_id.stamp == rospy.Time():
            self.status.goal_id.stamp = rospy.Time.now()
