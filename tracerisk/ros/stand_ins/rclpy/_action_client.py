"""Clients of actions: a future of the goal's handle, then one of its result.

What comes from the server waits until something spins the node.
"""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus
from action_msgs.srv import CancelGoal
from unique_identifier_msgs.msg import UUID

from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.messages.ros2 import copy_message
from tracerisk.ros.time.clock import EPOCH_NS

from ._bare_action_server import BareActionServer
from ._entity import Call, Entity
from ._handle import OF_NODE, Handle, check_context
from ._rclpy_pybind11 import RCLError
from ._run import run
from .callback_groups import CallbackGroup
from .executors import await_or_execute
from .qos import QoSProfile, qos_profile_action_status_default, qos_profile_services_default
from .task import Future
from .waitable import NumberOfEntities

__all__ = ["ActionClient", "ClientGoalHandle"]

_ORDER = ("goal", "cancel", "result", "feedback", "status")


@dataclass(eq=False, slots=True)
class _Sent:
    """A goal on its way and the futures that wait for it."""

    goal_id: Any
    """The identifier of the goal."""
    response: Future
    """The future of the goal's acceptance."""
    feedback_callback: Callable[[Any], Any] | None
    """The function for each feedback; `None`: none."""
    goal: ActionGoal | None = None
    """The goal; `None` before it is sent."""
    is_answered: bool = False
    """Whether the server has accepted or rejected it."""
    results: list[Future] = field(default_factory=list)
    """The futures that wait for the result."""
    cancels: list[Future] = field(default_factory=list)
    """The futures that wait for the answer to a request to cancel."""


class ClientGoalHandle:
    """A goal that a server has answered to."""

    def __init__(self, action_client: ActionClient, sent: _Sent, goal_response: Any) -> None:
        self._action_client = action_client
        self._sent = sent
        self._goal_response = goal_response
        self._status: int = GoalStatus.STATUS_UNKNOWN

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ClientGoalHandle) and self.goal_id == other.goal_id

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return (
            f"ClientGoalHandle <id={self.goal_id.uuid}, accepted={self.accepted}, "
            f"status={self.status}>"
        )

    goal_id = property(attrgetter("_sent.goal_id"), doc="The goal's UUID message.")

    stamp = property(attrgetter("_goal_response.stamp"), doc="When the server answered.")

    accepted = property(
        attrgetter("_goal_response.accepted"), doc="Whether the server took the goal."
    )

    @property
    def status(self) -> int:
        """What the goal has come to: a number of action_msgs/GoalStatus."""
        return self._status

    def cancel_goal(self) -> Any:
        """Ask for an early end and wait for the answer; another thread has to spin."""
        return self._action_client._wait(self.cancel_goal_async())

    def cancel_goal_async(self) -> Future:
        """Ask for an early end, and return the future of a CancelGoal response."""
        return self._action_client._cancel(self._sent)

    def get_result(self) -> Any:
        """Wait for the result; another thread has to spin."""
        return self._action_client._wait(self.get_result_async())

    def get_result_async(self) -> Future:
        """Return the future of the result: a response with `status` and `result`."""
        return self._action_client._result(self._sent)


class ActionClient(Entity):
    """Sends goals of one action type to a server."""

    def __init__(
        self,
        node: Any,
        action_type: Any,
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_sub_qos_profile: QoSProfile | None = None,
        status_sub_qos_profile: QoSProfile = qos_profile_action_status_default,
    ) -> None:
        super().__init__(node, callback_group or node.default_callback_group)
        with node.handle:
            if not node.context.is_valid:
                raise ValueError(f"Failed to create action client: {OF_NODE}")
        self._action_type = action_type
        self._action_name = node._resolved_action(action_name, "client")
        self._came: dict[str, deque[Any]] = {kind: deque() for kind in _ORDER}
        self._handles: dict[bytes, ClientGoalHandle] = {}
        self._end = run().actions.client(
            self._action_name,
            action_type._ros_type,
            node=node.get_fully_qualified_name(),
            copy=copy_message,
        )
        run().graph.carrier.pass_work("action client")
        self._bare: BareActionServer | None = None
        node.add_waitable(self)

    def send_goal(self, goal: Any, **kwargs: Any) -> Any:
        """Send a goal and wait for its result; another thread has to spin."""
        handle = self._wait(self.send_goal_async(goal, **kwargs))
        return self._wait(self._result(handle._sent))

    def _get_result_async(self, goal_handle: Any) -> Future:
        # Private, and called by programs all the same: examples of robot makers do.
        future: Future = goal_handle.get_result_async()
        return future

    def send_goal_async(
        self,
        goal: Any,
        feedback_callback: Callable[[Any], Any] | None = None,
        goal_uuid: Any = None,
    ) -> Future:
        """Send a goal, and return the future of its ClientGoalHandle.

        Raises:
            TypeError: the goal is no `Goal` of the action.
            RCLError: the client was destroyed.
        """
        if not isinstance(goal, self._action_type.Goal):
            raise TypeError(f"Expected {self._action_type.Goal}, got {type(goal)}")
        # One whose node was destroyed sends in silence to nobody.
        if self._is_destroyed and not self._node.handle._is_destroyed:
            raise RCLError("Failed to send goal request: action client pointer is invalid")
        goal_id = UUID(uuid=list(uuid.uuid4().bytes)) if goal_uuid is None else goal_uuid
        text = f"action server {self._action_name} ({self._action_type._ros_type})"
        bare = self._bare_server()
        if bare is not None:
            return self._send_to_bare(bare, goal_id, goal, feedback_callback)
        sent = _Sent(
            goal_id, Future(waits_for=f"the answer of {text}", source=self), feedback_callback
        )
        sent.goal = self._end.send(
            goal,
            goal_id=bytes(goal_id.uuid),
            on_change=lambda changed: self._on_change(sent, changed),
            on_feedback=lambda changed, feedback: self._on_feedback(sent, feedback),
        )
        return sent.response

    def _bare_server(self) -> BareActionServer | None:
        """Return the server that the program makes of bare services, if it does."""
        if self._bare is None and BareActionServer.is_there(self._action_type, self._action_name):
            self._bare = BareActionServer(self._node, self._action_type, self._action_name)
        return self._bare

    def _send_to_bare(
        self,
        bare: BareActionServer,
        goal_id: Any,
        goal: Any,
        feedback_callback: Callable[[Any], Any] | None,
    ) -> Future:
        text = f"the answer of action server {self._action_name}"
        sent = _Sent(goal_id, Future(waits_for=text, source=self), feedback_callback)

        def answered(future: Future) -> None:
            handle = ClientGoalHandle(self, sent, future.result())
            self._handles[bytes(goal_id.uuid)] = handle
            sent.response.set_result(handle)

        bare.send(goal_id, goal, feedback_callback).add_done_callback(answered)
        return sent.response

    def server_is_ready(self) -> bool:
        """Return whether somebody serves the action.

        Raises:
            InvalidHandle: client or node was destroyed.
            RCLError: the context was shut down.
        """
        with self._node.handle, self.handle:
            check_context(self._node.context, "Failed to check if action server is available")
        run().scheduler.touch()
        return self._end.is_served() or self._bare_server() is not None

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Wait until somebody serves the action, and return whether somebody does."""
        timeout_ns = None if timeout_sec is None else max(0, round(timeout_sec * 1e9))
        context = self._node.context
        if self._bare_server() is not None:
            return self.server_is_ready()
        self._end.wait_for_server(timeout_ns, unless=lambda: not context.is_valid)
        return self.server_is_ready()

    def __enter__(self) -> Handle:
        return self.handle.__enter__()

    def __exit__(self, *error: object) -> None:
        self.handle.__exit__(*error)

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities of each kind a client is made of."""
        return NumberOfEntities(num_subs=2, num_clients=3)

    def destroy(self) -> None:
        """Send no more goals."""
        super().destroy()
        self._end.close()
        if self._bare is not None:
            self._bare.destroy()
        self._node.remove_waitable(self)

    # What comes from the server

    def _on_change(self, sent: _Sent, goal: ActionGoal) -> None:
        state = goal.state
        if not sent.is_answered and state is not GoalState.PENDING:
            sent.is_answered = True
            response = self._action_type.Impl.SendGoalService.Response()
            response.accepted = state is not GoalState.REJECTED
            now_ns = EPOCH_NS + run().scheduler.now_ns
            response.stamp.sec, response.stamp.nanosec = divmod(now_ns, 1_000_000_000)
            self._came["goal"].append((sent, response))
        self._came["status"].append((sent, state.ros2_status))
        if sent.cancels and (state.is_cancelling or state.is_terminal or not goal.is_cancel_asked):
            self._answer_cancels(sent, goal)
        if state.is_terminal and sent.results:
            for future in sent.results:
                self._came["result"].append((future, self._result_of(goal)))
            sent.results.clear()

    def _on_feedback(self, sent: _Sent, feedback: Any) -> None:
        if sent.feedback_callback is not None:
            message = self._action_type.Impl.FeedbackMessage(
                goal_id=sent.goal_id, feedback=feedback
            )
            self._came["feedback"].append((sent.feedback_callback, message))

    def _result_of(self, goal: ActionGoal) -> Any:
        response = self._action_type.Impl.GetResultService.Response()
        response.status = goal.state.ros2_status
        if goal.result is not None:
            response.result = goal.result
        return response

    def _result(self, sent: _Sent) -> Future:
        if sent.goal is None and self._bare is not None:
            return self._bare.result(sent.goal_id)
        text = f"the result of a goal of {self._action_name} ({self._action_type._ros_type})"
        future = Future(waits_for=text, source=self)
        goal = sent.goal
        if goal is None or goal.state is GoalState.REJECTED:
            # A server knows nothing of a goal that it refused.
            self._came["result"].append(
                (future, self._action_type.Impl.GetResultService.Response())
            )
        elif goal.state.is_terminal:
            self._came["result"].append((future, self._result_of(goal)))
        else:
            sent.results.append(future)
        return future

    def _cancel(self, sent: _Sent) -> Future:
        if sent.goal is None and self._bare is not None:
            return self._bare.cancel(sent.goal_id)
        future = Future(waits_for=f"the answer of action server {self._action_name} to a cancel")
        goal = sent.goal
        if goal is None or goal.state.is_terminal:
            response = CancelGoal.Response(return_code=CancelGoal.Response.ERROR_GOAL_TERMINATED)
            if goal is None or goal.state is GoalState.REJECTED:
                response.return_code = CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
            self._came["cancel"].append((future, response))
            if goal is not None:
                goal.ask_cancel()
            return future
        sent.cancels.append(future)
        goal.ask_cancel()
        served_by_twin = goal.server is not None and not goal.server.by_controller
        is_read = served_by_twin and not goal.is_cancel_unread
        if sent.cancels and (is_read or goal.state.is_cancelling):
            self._answer_cancels(sent, goal)
        return future

    def _answer_cancels(self, sent: _Sent, goal: ActionGoal) -> None:
        response = CancelGoal.Response()
        by_rclpy = goal.server is not None and goal.server.by_controller
        # The goal has ended before its server came to the request, as where its thread was busy.
        is_unread = goal.is_cancel_unread or (by_rclpy and goal.is_cancel_asked)
        if goal.state.is_cancelling:
            response.goals_canceling.append(GoalInfo(goal_id=sent.goal_id))
        elif goal.state.is_terminal and is_unread:
            response.return_code = CancelGoal.Response.ERROR_GOAL_TERMINATED
        elif not by_rclpy:
            # Servers of rclpy name no goal and no error; those in C++ say that they refuse.
            response.return_code = CancelGoal.Response.ERROR_REJECTED
        for future in sent.cancels:
            self._came["cancel"].append((future, response))
        sent.cancels.clear()

    # What the executor runs

    def _is_ready(self) -> bool:
        return any(self._came.values())

    def _take(self, executor: Any) -> Call | None:
        taken = {kind: came.popleft() for kind, came in self._came.items() if came}

        async def call() -> None:
            if "goal" in taken:
                sent, response = taken["goal"]
                handle = ClientGoalHandle(self, sent, response)
                if handle.accepted:
                    self._handles[bytes(sent.goal_id.uuid)] = handle
                self._complete(executor, sent.response, handle)
            for kind in ("cancel", "result"):
                if kind in taken:
                    future, response = taken[kind]
                    self._complete(executor, future, response)
            if "feedback" in taken:
                callback, message = taken["feedback"]
                await await_or_execute(callback, message)
            if "status" in taken:
                sent, status = taken["status"]
                known = self._handles.get(bytes(sent.goal_id.uuid))
                if known is not None:
                    known._status = status

        return call

    @staticmethod
    def _complete(executor: Any, future: Future, result: Any) -> None:
        if not future._done:
            future._set_executor(executor)
            future.set_result(result)

    def _wait(self, future: Future) -> Any:
        run().scheduler.wait_until(
            lambda: future._done,
            reason=future._awaited or "a future",
            kind=self._meaning_of_answer,
        )
        return future.result()
