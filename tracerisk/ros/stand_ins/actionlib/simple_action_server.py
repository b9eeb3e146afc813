"""The server that pursues one goal at a time; a new goal preempts the one before."""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import rospy
from actionlib_msgs.msg import GoalStatus

from tracerisk.ros.graph.action_goal import GoalState
from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.graph.runtime import current

from ._node import is_shut_down
from .action_server import ActionServer, nop_cb
from .server_goal_handle import ServerGoalHandle

__all__ = ["ActionServer", "GoalStatus", "ServerGoalHandle", "SimpleActionServer", "nop_cb"]

_SUPERSEDED = "This goal was canceled because another goal was received by the simple action server"


class SimpleActionServer:
    """Serve the action `name` of type `ActionSpec`, one goal at a time.

    `execute_cb` gets each goal's message on a thread of its own, which keeps the process alive
    until the node shuts down; without it, the user polls
    `is_new_goal_available` or registers a goal callback, and calls `accept_new_goal`.

    Raises:
        ActionException: `ActionSpec` is not an action's message, such as `FibonacciAction`.
    """

    def __init__(
        self,
        name: str,
        ActionSpec: Any,
        execute_cb: Callable[[Any], object] | None = None,
        auto_start: bool = True,
    ) -> None:
        self.new_goal = False
        self.preempt_request = False
        self.new_goal_preempt_request = False
        self.execute_callback = execute_cb
        self.goal_callback: Callable[[], object] | None = None
        self.preempt_callback: Callable[[], object] | None = None
        self.lock = threading.RLock()
        self.current_goal = ServerGoalHandle()
        self.next_goal = ServerGoalHandle()
        if execute_cb is not None:
            # As there no daemon: the process lives until the node shuts down.
            current().scheduler.spawn(
                self.executeLoop,
                f"action {name}",
                daemon=False,
                inherit=False,
                is_controllers=False,
            )
        self.action_server = ActionServer(
            name,
            ActionSpec,
            self.internal_goal_callback,
            self.internal_preempt_callback,
            auto_start,
        )

    def accept_new_goal(self) -> Any:
        """Take the new goal, preempt the one before, and return the goal's message.

        None, with an error logged, where no goal is new.
        """
        if not self.new_goal or self.next_goal.get_goal() is None:
            rospy.logerr("Attempting to accept the next goal when a new goal is not available")
            return None
        if self._is_active() and self.current_goal != self.next_goal:
            self.current_goal.set_canceled(None, _SUPERSEDED)
        self.current_goal = self.next_goal
        self.new_goal = False
        self.preempt_request = self.new_goal_preempt_request
        self.new_goal_preempt_request = False
        self.current_goal.set_accepted("This goal has been accepted by the simple action server")
        return self.current_goal.get_goal()

    def is_new_goal_available(self) -> bool:
        """Return whether a goal waits to be accepted."""
        current().scheduler.touch()
        return self.new_goal

    def is_preempt_requested(self) -> bool:
        """Return whether the current goal is to end early."""
        current().scheduler.touch()
        return self.preempt_request

    def is_active(self) -> bool:
        """Return whether a goal is being pursued."""
        current().scheduler.touch()
        return self._is_active()

    def set_succeeded(self, result: Any = None, text: str = "") -> None:
        """End the goal as reached."""
        self.current_goal.set_succeeded(result or self.get_default_result(), text)

    def set_aborted(self, result: Any = None, text: str = "") -> None:
        """End the goal as failed."""
        self.current_goal.set_aborted(result or self.get_default_result(), text)

    def set_preempted(self, result: Any = None, text: str = "") -> None:
        """End the goal early."""
        self.current_goal.set_canceled(result or self.get_default_result(), text)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the goal's client."""
        self.current_goal.publish_feedback(feedback)

    def get_default_result(self) -> Any:
        """Return an empty result of the action."""
        return self.action_server.ActionResultType()

    def register_goal_callback(self, cb: Callable[[], object]) -> None:
        """Call `cb` when a goal comes; not with an `execute_cb`."""
        if self.execute_callback is not None:
            rospy.logwarn(
                "Cannot call SimpleActionServer.register_goal_callback() because an "
                "executeCallback exists. Not going to register it."
            )
        else:
            self.goal_callback = cb

    def register_preempt_callback(self, cb: Callable[[], object]) -> None:
        """Call `cb` when the current goal is to end early."""
        self.preempt_callback = cb

    def start(self) -> None:
        """Begin to serve."""
        self.action_server.start()

    def internal_goal_callback(self, goal: ServerGoalHandle) -> None:
        """Take a goal that came: it is the next one, and the one before it gets notice."""
        if self.next_goal.get_goal() is not None and self.next_goal != self.current_goal:
            # Nobody took it: it gives way before it has begun.
            self.next_goal.set_canceled(None, _SUPERSEDED)
        self.next_goal = goal
        self.new_goal = True
        self.new_goal_preempt_request = False
        if self._is_active():
            self.preempt_request = True
            if self.preempt_callback is not None:
                self.preempt_callback()
        if self.goal_callback is not None:
            self.goal_callback()

    def internal_preempt_callback(self, preempt: ServerGoalHandle) -> None:
        """Take that a goal is to end early."""
        if preempt == self.current_goal:
            self.preempt_request = True
            if self.preempt_callback is not None:
                self.preempt_callback()
        elif preempt == self.next_goal:
            self.new_goal_preempt_request = True

    def executeLoop(self) -> None:
        """Execute goals as they come until the node shuts down."""
        run = current()
        while True:
            run.scheduler.wait_until(
                lambda: self.new_goal or is_shut_down(), reason="goals", kind="idle"
            )
            if is_shut_down():
                return
            goal = self.accept_new_goal()
            tracer: Any = run.tracer
            root: Any = nullcontext() if tracer is None else tracer.root("callback")
            with root:
                self._execute(goal)

    def _execute(self, goal: Any) -> None:
        if self.execute_callback is None:
            return
        try:
            self.execute_callback(goal)
            if self._is_active():
                rospy.logwarn(
                    "Your executeCallback did not set the goal to a terminal status. This is a "
                    "bug in your ActionServer implementation. Fix your code! For now, the "
                    "ActionServer will set this goal to aborted"
                )
                self.set_aborted(None, "No terminal state was set.")
        except Exception as error:  # noqa: BLE001 - the controller's; the goal is aborted with it
            shown = "".join(traceback.format_exception(error)).rstrip()
            callback_failed("the execute callback of an action server", error)
            rospy.logerr("Exception in your execute callback: %s\n%s", error, shown)
            self.set_aborted(None, f"Exception in execute callback: {error}")

    def _is_active(self) -> bool:
        goal = self.current_goal.status_tracker
        return goal is not None and goal.state in (GoalState.ACTIVE, GoalState.PREEMPTING)
