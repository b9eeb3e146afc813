"""A state that sends a goal to an action and waits for its end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import rospy
import smach
from actionlib import GoalStatus, SimpleActionClient

from .slots import Slots


class SimpleActionState(smach.State):  # type: ignore[misc]
    """Ends as the goal does: `succeeded`, `aborted` or `preempted`."""

    def __init__(
        self,
        action_name: str,
        action_spec: Any,
        goal: Any = None,
        goal_key: str | None = None,
        goal_slots: Iterable[str] = (),
        goal_cb: Callable[..., Any] | None = None,
        goal_cb_args: Sequence[Any] = (),
        goal_cb_kwargs: dict[str, Any] | None = None,
        result_key: str | None = None,
        result_slots: Iterable[str] = (),
        result_cb: Callable[..., Any] | None = None,
        result_cb_args: Sequence[Any] = (),
        result_cb_kwargs: dict[str, Any] | None = None,
        input_keys: Iterable[str] = (),
        output_keys: Iterable[str] = (),
        outcomes: Iterable[str] = (),
        exec_timeout: Any = None,
        cancel_timeout: Any = None,
        preempt_timeout: Any = None,
        server_wait_timeout: Any = None,
    ) -> None:
        super().__init__(("succeeded", "aborted", "preempted", *outcomes), input_keys, output_keys)
        self._action_name, self._action_spec = action_name, action_spec
        self._goal = Slots(goal, goal_key, goal_slots, goal_cb, goal_cb_args, goal_cb_kwargs)
        self._result = Slots(
            None, result_key, result_slots, result_cb, result_cb_args, result_cb_kwargs
        )
        self.register_input_keys(self._goal.keys)
        self.register_output_keys(self._result.keys)
        self.register_outcomes(self._result.outcomes)
        self._exec_timeout = exec_timeout
        self._server_wait_timeout = server_wait_timeout or rospy.Duration(60.0)
        self._client: Any = None

    def request_preempt(self) -> None:
        """Ask the state to end, and cancel its goal."""
        super().request_preempt()
        if self._client is not None:
            self._client.cancel_goal()

    def execute(self, ud: Any) -> str:
        """Send the goal; return how it ended."""
        if self.preempt_requested():
            self.service_preempt()
            return "preempted"
        client = SimpleActionClient(self._action_name, self._action_spec)
        if not client.wait_for_server(self._server_wait_timeout):
            smach.logerr(f"no server of action {self._action_name} runs")
            return "aborted"
        goal = self._goal.filled(ud, type(self._action_spec().action_goal.goal))
        self._client = client
        try:
            client.send_goal(goal)
            if not client.wait_for_result(self._exec_timeout or rospy.Duration(0)):
                client.cancel_goal()
                client.wait_for_result(rospy.Duration(15.0))
        finally:
            self._client = None
        status = client.get_state()
        outcome = self._result.keep(ud, client.get_result(), status)
        if self.preempt_requested():
            self.service_preempt()
            return outcome or "preempted"
        if outcome is not None and outcome in self.get_registered_outcomes():
            return outcome
        if status == GoalStatus.SUCCEEDED:
            return "succeeded"
        return "preempted" if status == GoalStatus.PREEMPTED else "aborted"
