"""A goal as its server holds it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus

from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.time.clock import EPOCH_NS

if TYPE_CHECKING:
    from .action_server import ActionServer

_PURSUED = (GoalState.ACTIVE, GoalState.PREEMPTING)
_UNTAKEN = (GoalState.PENDING, GoalState.RECALLING)


class ServerGoalHandle:
    """Take, reject and end one goal; a step that its state does not allow is logged as an error."""

    def __init__(
        self,
        status_tracker: ActionGoal | None = None,
        action_server: ActionServer | None = None,
        handle_tracker: Any = None,
    ) -> None:
        self.status_tracker = status_tracker
        self.action_server = action_server
        self.handle_tracker = handle_tracker
        self.goal: Any = None
        if status_tracker is not None and action_server is not None:
            # The message as it came, in which the goal is one of the fields.
            self.goal = action_server.ActionGoal(goal_id=self.get_goal_id())
            self.goal.header.stamp = self.goal.goal_id.stamp
            self.goal.goal = status_tracker.message

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ServerGoalHandle)
            and self.status_tracker is not None
            and self.status_tracker is other.status_tracker
        )

    def __hash__(self) -> int:
        return hash(self.get_goal_id().id)

    def get_default_result(self) -> Any:
        """Return an empty result of the action."""
        if self.action_server is None:
            return None
        return self.action_server.ActionResultType()

    def set_accepted(self, text: str = "") -> None:
        """Take the goal: it is ACTIVE, or PREEMPTING where it was to be recalled."""
        goal = self._allowed(_UNTAKEN, "an active", "a pending or recalling")
        if goal is not None:
            goal.accept(text)

    def set_canceled(self, result: Any = None, text: str = "") -> None:
        """End the goal early: PREEMPTED, or RECALLED where it was not taken yet."""
        goal = self._allowed(
            (*_UNTAKEN, *_PURSUED),
            "a cancelled",
            "a pending, recalling, active, or preempting",
        )
        if goal is not None:
            goal.cancel(self._given(result), text)

    def set_rejected(self, result: Any = None, text: str = "") -> None:
        """Refuse the goal."""
        goal = self._allowed(_UNTAKEN, "a rejected", "a pending or recalling")
        if goal is not None:
            goal.reject(text, self._given(result))

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the goal as failed."""
        goal = self._allowed(_PURSUED, "an aborted", "a preempting or active")
        if goal is not None:
            goal.abort(self._given(result), text)

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the goal as reached."""
        goal = self._allowed(_PURSUED, "a succeeded", "a preempting or active")
        if goal is not None:
            goal.succeed(self._given(result), text)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the goal's client."""
        if self.status_tracker is None:
            rospy.logerr("Attempt to publish feedback on an uninitialized ServerGoalHandle")
        else:
            self.status_tracker.publish_feedback(feedback)

    def get_goal(self) -> Any:
        """Return the goal message, None for a handle of no goal."""
        return None if self.goal is None else self.goal.goal

    def get_goal_id(self) -> Any:
        """Return the goal's id, with the time at which it was sent."""
        if self.status_tracker is None:
            rospy.logerr("Attempt to get a goal id on an uninitialized ServerGoalHandle")
            return GoalID()
        stamp = rospy.Time(0, EPOCH_NS + self.status_tracker.sent_ns)
        return GoalID(stamp, str(self.status_tracker.id))

    def get_goal_status(self) -> Any:
        """Return the goal's `GoalStatus` message."""
        goal = self.status_tracker
        if goal is None:
            rospy.logerr("Attempt to get goal status on an uninitialized ServerGoalHandle")
            return GoalStatus()
        return GoalStatus(self.get_goal_id(), goal.state.ros1_status, goal.text)

    def set_cancel_requested(self) -> bool:
        """Note that the goal is to end early; return whether the server's callback should know."""
        goal = self.status_tracker
        if goal is None or goal.state not in (GoalState.PENDING, GoalState.ACTIVE):
            return False
        goal.accept_cancel()
        return True

    def _given(self, result: Any) -> Any:
        return result or self.get_default_result()

    def _allowed(self, allowed: tuple[GoalState, ...], step: str, states: str) -> ActionGoal | None:
        goal = self.status_tracker
        if goal is None:
            rospy.logerr("Attempt to set status on an uninitialized ServerGoalHandle")
            return None
        if goal.state not in allowed:
            rospy.logerr(
                "To transition to %s state, the goal must be in %s state, "
                "it is currently in state: %d",
                step,
                states,
                goal.state.ros1_status,
            )
            return None
        return goal
