"""The server that passes on each goal, and leaves what becomes of it to its user."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray  # noqa: F401 - names of this module too

from tracerisk.ros.graph.action_ends import ActionServerEnd
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.callback_thread import CallbackThread
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.exported import defined as _defined

from ._node import action_name, action_parts, call_back, sent
from .exceptions import ActionException  # noqa: F401 - names of this module too
from .goal_id_generator import GoalIDGenerator  # noqa: F401 - names of this module too
from .server_goal_handle import ServerGoalHandle


def nop_cb(goal_handle: ServerGoalHandle) -> None:
    """Do nothing."""


class ActionServer:
    """Serve the action `ns` of type `ActionSpec`.

    `goal_cb` gets a handle of each new goal, `cancel_cb` that of a goal which is to end early;
    both run on a thread of the server.

    Raises:
        ActionException: `ActionSpec` is not an action's message, such as `FibonacciAction`.
    """

    def __init__(
        self,
        ns: str,
        ActionSpec: Any,
        goal_cb: Callable[[ServerGoalHandle], object],
        cancel_cb: Callable[[ServerGoalHandle], object] = nop_cb,
        auto_start: bool = True,
    ) -> None:
        self.ns = ns
        self.ActionSpec = ActionSpec
        self._parts = action_parts(ActionSpec)
        self.ActionGoal, self.ActionResult, self.ActionFeedback = self._parts.wrappers
        self.ActionResultType = self._parts.messages[1]
        self.goal_callback = goal_cb
        self.cancel_callback = cancel_cb
        self.auto_start = auto_start
        self.started = False
        self.lock = threading.RLock()
        self._end: ActionServerEnd | None = None
        run = current()
        self._name = action_name(ns)
        self._calls = CallbackThread(run.scheduler, run.tracer, f"action server {self._name}")
        if auto_start:
            rospy.logwarn(
                "You've passed in true for auto_start to the python action server, you should "
                "always pass in false to avoid race conditions."
            )
            self.start()

    def register_goal_callback(self, cb: Callable[[ServerGoalHandle], object]) -> None:
        """Take another callback for goals."""
        self.goal_callback = cb

    def register_cancel_callback(self, cancel_cb: Callable[[ServerGoalHandle], object]) -> None:
        """Take another callback for goals that are to end early."""
        self.cancel_callback = cancel_cb

    def start(self) -> None:
        """Begin to serve."""
        if self._end is None:
            self._end = (
                current()
                .client(Actions)
                .serve(
                    self._name,
                    self._parts.type_name,
                    node=rospy.get_name(),
                    on_goal=lambda goal: self._put(lambda: self.internal_goal_callback(goal)),
                    on_cancel=lambda goal: self._put(lambda: self.internal_cancel_callback(goal)),
                    copy=sent,
                )
            )
        self.started = True

    def stop(self) -> None:
        """Serve no more."""
        self.started = False
        if self._end is not None:
            self._end.close()
            self._end = None

    def internal_goal_callback(self, goal: ActionGoal) -> None:
        """Take a goal that came."""
        if self.started:
            self.goal_callback(ServerGoalHandle(goal, self))

    def internal_cancel_callback(self, goal: ActionGoal) -> None:
        """Take that a goal is to end early."""
        handle = ServerGoalHandle(goal, self)
        if self.started and handle.set_cancel_requested():
            self.cancel_callback(handle)

    def _put(self, call: Callable[[], None]) -> None:
        self._calls.put(lambda: call_back(call, f"server {self._name}"))


__all__ = _defined(
    globals(),
    "ActionException",
    "GoalID",
    "GoalIDGenerator",
    "GoalStatus",
    "GoalStatusArray",
    "ServerGoalHandle",
)
