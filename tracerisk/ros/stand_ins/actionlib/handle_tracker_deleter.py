"""When a server of actions learns that a program has dropped its handle of a goal."""

from __future__ import annotations

from typing import Any

import rospy


class HandleTrackerDeleter:
    """Called when the handle of a goal is dropped: notes the time in the goal's status."""

    def __init__(self, action_server: Any, status_tracker: Any) -> None:
        self.action_server = action_server
        self.status_tracker = status_tracker

    def __call__(self, ptr: Any) -> None:
        """Note the time."""
        if self.action_server:
            with self.action_server.lock:
                self.status_tracker.handle_destruction_time = rospy.Time.now()
