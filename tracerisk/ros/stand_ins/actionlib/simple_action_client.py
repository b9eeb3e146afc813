"""The client that follows one goal at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
from actionlib_msgs.msg import GoalStatus
from rospy._node import node
from rospy.rostime import duration_ns

from tracerisk.ros.graph.runtime import current

from .action_client import ActionClient, ClientGoalHandle, CommState, get_name_of_constant

__all__ = ["ActionClient", "CommState", "GoalStatus", "SimpleActionClient", "SimpleGoalState"]

_FOR_EVER = rospy.Duration()


class SimpleGoalState:
    """What a simple client knows of its goal."""

    PENDING = 0
    ACTIVE = 1
    DONE = 2

    to_string = classmethod(get_name_of_constant)


class SimpleActionClient:
    """Send goals to the action `ns` of type `ActionSpec` and follow the last one.

    Raises:
        ActionException: `ActionSpec` is not an action's message, such as `FibonacciAction`.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.action_client = ActionClient(ns, ActionSpec)
        self.simple_state = SimpleGoalState.DONE
        self.gh: ClientGoalHandle | None = None
        self.done_cb: Callable[[int, Any], object] | None = None
        self.active_cb: Callable[[], object] | None = None
        self.feedback_cb: Callable[[Any], object] | None = None

    def wait_for_server(self, timeout: Any = _FOR_EVER) -> bool:
        """Wait until somebody serves the action; a zero timeout waits for ever."""
        return self.action_client.wait_for_server(timeout)

    def send_goal(
        self,
        goal: Any,
        done_cb: Callable[[int, Any], object] | None = None,
        active_cb: Callable[[], object] | None = None,
        feedback_cb: Callable[[Any], object] | None = None,
    ) -> None:
        """Send a goal; one that was sent before is forgotten, but not cancelled.

        `done_cb` gets the terminal state and the result, `feedback_cb` each feedback.
        """
        self.stop_tracking_goal()
        self.done_cb, self.active_cb, self.feedback_cb = done_cb, active_cb, feedback_cb
        self.simple_state = SimpleGoalState.PENDING
        self.gh = self.action_client.send_goal(goal, self._handle_transition, self._handle_feedback)

    def send_goal_and_wait(
        self,
        goal: Any,
        execute_timeout: Any = _FOR_EVER,
        preempt_timeout: Any = _FOR_EVER,
    ) -> int:
        """Send a goal, wait until it is done and return its state.

        After `execute_timeout` the goal is cancelled, and that is waited for at most
        `preempt_timeout`; zero waits for ever.
        """
        self.send_goal(goal)
        if not self.wait_for_result(execute_timeout):
            rospy.logdebug("Canceling goal")
            self.cancel_goal()
            text = "finished within" if self.wait_for_result(preempt_timeout) else "didn't finish"
            rospy.logdebug("Preempt %s specified preempt_timeout", text)
        return self.get_state()

    def wait_for_result(self, timeout: Any = _FOR_EVER) -> bool:
        """Wait until the goal is done, for ever with a zero timeout; return whether it is.

        `done_cb` has returned by then.

        Raises:
            TypeError: the timeout is not a Duration.
        """
        if self.gh is None:
            rospy.logerr("Called wait_for_result when no goal exists")
            return False
        # The real one adds it to the present time, which takes nothing but a Duration.
        _ = rospy.get_rostime() + timeout
        timeout_ns = duration_ns(timeout)
        served = self.action_client.is_served()
        node().wait(
            lambda: self.simple_state == SimpleGoalState.DONE,
            timeout_ns if timeout_ns > 0 else None,
            f"the result of action {self.action_client.words}",
            "blocked" if served else "unmet",
        )
        return self.simple_state == SimpleGoalState.DONE

    def get_result(self) -> Any:
        """Return the result of the goal, None where there is none yet."""
        if self.gh is None:
            rospy.logerr("Called get_result when no goal is running")
            return None
        return self.gh.get_result()

    def get_state(self) -> int:
        """Return the goal's `GoalStatus`, LOST where no goal is followed.

        A goal that is being recalled is PENDING, one that is being preempted ACTIVE.
        """
        if self.gh is None:
            current().scheduler.touch()
            return int(GoalStatus.LOST)
        status = self.gh.get_goal_status()
        if status == GoalStatus.RECALLING:
            return int(GoalStatus.PENDING)
        if status == GoalStatus.PREEMPTING:
            return int(GoalStatus.ACTIVE)
        return status

    def get_goal_status_text(self) -> str:
        """Return what the server said with the goal's last state."""
        if self.gh is None:
            message = "Called get_goal_status_text when no goal is running"
            rospy.logerr(message)
            return f"ERROR: {message}"
        return self.gh.get_goal_status_text()

    def cancel_all_goals(self) -> None:
        """Ask the server to end all its goals early, those of other clients too."""
        self.action_client.cancel_all_goals()

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to end early the goals that were sent until `time`."""
        self.action_client.cancel_goals_at_and_before_time(time)

    def cancel_goal(self) -> None:
        """Ask the server to end the goal early."""
        if self.gh is not None:
            self.gh.cancel()

    def stop_tracking_goal(self) -> None:
        """Forget the goal without cancelling it; its callbacks are called no more."""
        self.gh = None

    def _handle_transition(self, gh: ClientGoalHandle) -> None:
        # A goal that was forgotten reports nothing any more; one just sent has no handle yet only
        # within `send_goal`, where nothing is reported.
        if gh != self.gh:
            return
        state = gh.comm_state_machine.state
        if state in (CommState.ACTIVE, CommState.PREEMPTING):
            if self.simple_state == SimpleGoalState.PENDING:
                self.simple_state = SimpleGoalState.ACTIVE
                if self.active_cb is not None:
                    self.active_cb()
        elif state == CommState.DONE and self.simple_state != SimpleGoalState.DONE:
            machine = gh.comm_state_machine
            if self.done_cb is not None:
                self.done_cb(int(machine.latest_goal_status.status), machine.latest_result)
            # A callback that sent the next goal has made this one history.
            if gh == self.gh:
                self.simple_state = SimpleGoalState.DONE

    def _handle_feedback(self, gh: ClientGoalHandle, feedback: Any) -> None:
        if gh == self.gh and self.feedback_cb is not None:
            self.feedback_cb(feedback)
