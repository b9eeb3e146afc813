"""Servers of actions: goals are taken, executed and cancelled by callbacks of the node."""

from __future__ import annotations

import traceback
from collections import deque
from collections.abc import Callable
from enum import Enum
from operator import attrgetter
from typing import Any

from action_msgs.msg import GoalInfo
from unique_identifier_msgs.msg import UUID

from tracerisk.ros.graph.action_goal import ActionGoal, GoalState, GoalStateError
from tracerisk.ros.graph.failures import callback_failed
from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.messages.ros2 import copy_message

from ._entity import Call, Entity
from ._handle import Handle
from ._rclpy_pybind11 import GoalEvent, RCLError
from ._run import run
from .callback_groups import CallbackGroup
from .constants import S_TO_NS
from .executors import await_or_execute
from .qos import QoSProfile, qos_profile_action_status_default, qos_profile_services_default
from .waitable import NumberOfEntities

_NAMES_IN_RCL = {"ACTIVE": "EXECUTING", "PREEMPTING": "CANCELING", "PREEMPTED": "CANCELED"}


class GoalResponse(Enum):
    """What a goal callback decides."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(Enum):
    """What a cancel callback decides."""

    REJECT = 1
    ACCEPT = 2


class ServerGoalHandle:
    """A goal that the server has taken."""

    def __init__(self, action_server: ActionServer, goal: ActionGoal, request: Any) -> None:
        self._action_server = action_server
        self._goal = goal
        self._request = request
        self._end: GoalState | None = None
        self._ended_ns: int | None = None
        self._goal_info = GoalInfo(
            goal_id=UUID(uuid=list(goal.id) if isinstance(goal.id, bytes) else [0] * 16),
            stamp=action_server._node.get_clock().now().to_msg(),
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ServerGoalHandle) and self.goal_id == other.goal_id

    __hash__ = None  # type: ignore[assignment]

    request = property(attrgetter("_request"), doc="The goal message.")

    goal_id = property(attrgetter("_goal_info.goal_id"), doc="The goal's UUID message.")

    @property
    def is_active(self) -> bool:
        """Whether the goal has not come to its end."""
        return self._end is None and not self._goal.state.is_terminal

    @property
    def is_cancel_requested(self) -> bool:
        """Whether a cancel request was accepted; a loop that polls moves the clock."""
        run().scheduler.touch()
        return self._end is None and self._goal.state is GoalState.PREEMPTING

    @property
    def status(self) -> int:
        """What the goal has come to: a number of action_msgs/GoalStatus."""
        status: int = (self._end or self._goal.state).ros2_status
        return status

    def execute(self, execute_callback: Callable[[Any], Any] | None = None) -> None:
        """Execute the goal, by the server's callback or another."""
        if self._goal.state is GoalState.ACCEPTED:
            self._goal.execute()
        self._action_server._notify_execute(self, execute_callback)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback.

        Raises:
            TypeError: it is no `Feedback` of the action.
        """
        expected = self._action_server.action_type.Feedback
        if not isinstance(feedback, expected):
            raise TypeError(f"Expected {expected}, got {type(feedback)}")
        self._goal.publish_feedback(feedback)

    def succeed(self) -> None:
        """Mark the goal as reached; the result follows when the callback returns."""
        self._finish(GoalEvent.SUCCEED, GoalState.SUCCEEDED, GoalState.ACTIVE, GoalState.PREEMPTING)

    def abort(self) -> None:
        """Mark the goal as failed."""
        self._finish(GoalEvent.ABORT, GoalState.ABORTED, GoalState.ACTIVE, GoalState.PREEMPTING)

    def canceled(self) -> None:
        """Mark the goal as canceled."""
        self._finish(GoalEvent.CANCELED, GoalState.PREEMPTED, GoalState.PREEMPTING)

    def destroy(self) -> None:
        """Forget the goal."""

    def _finish(self, event: GoalEvent, end: GoalState, *allowed: GoalState) -> None:
        if self._end is not None or self._goal.state not in allowed:
            state = (self._end or self._goal.state).name
            raise RCLError(
                f"Failed to update goal state: goal_handle attempted invalid transition from "
                f"state {_NAMES_IN_RCL.get(state, state)} with event {event.name}"
            )
        self._end = end

    def _send(self, result: Any) -> None:
        step = {
            GoalState.SUCCEEDED: self._goal.succeed,
            GoalState.ABORTED: self._goal.abort,
            GoalState.PREEMPTED: self._goal.cancel,
        }[self._end or GoalState.ABORTED]
        step(result)


def default_handle_accepted_callback(goal_handle: ServerGoalHandle) -> None:
    """Execute the goal at once."""
    goal_handle.execute()


def default_goal_callback(goal_request: Any) -> GoalResponse:
    """Accept every goal."""
    return GoalResponse.ACCEPT


def default_cancel_callback(cancel_request: Any) -> CancelResponse:
    """Refuse every cancel request."""
    return CancelResponse.REJECT


class ActionServer(Entity):
    """Serves one action."""

    def __init__(
        self,
        node: Any,
        action_type: Any,
        action_name: str,
        execute_callback: Callable[[ServerGoalHandle], Any],
        *,
        callback_group: CallbackGroup | None = None,
        goal_callback: Callable[[Any], Any] | None = default_goal_callback,
        handle_accepted_callback: Callable[[Any], Any] | None = default_handle_accepted_callback,
        cancel_callback: Callable[[Any], Any] | None = default_cancel_callback,
        goal_service_qos_profile: QoSProfile = qos_profile_services_default,
        result_service_qos_profile: QoSProfile = qos_profile_services_default,
        cancel_service_qos_profile: QoSProfile = qos_profile_services_default,
        feedback_pub_qos_profile: QoSProfile | None = None,
        status_pub_qos_profile: QoSProfile = qos_profile_action_status_default,
        result_timeout: int = 10,
    ) -> None:
        super().__init__(node, callback_group or node.default_callback_group)
        self._action_type = action_type
        self._queue: deque[tuple[str, ActionGoal]] = deque()
        self._result_timeout_ns = result_timeout * S_TO_NS
        self._handles: dict[int, ServerGoalHandle] = {}
        self.register_handle_accepted_callback(handle_accepted_callback)
        self.register_goal_callback(goal_callback)
        self.register_cancel_callback(cancel_callback)
        self.register_execute_callback(execute_callback)
        self._end = run().actions.serve(
            node._resolved_action(action_name, "server"),
            action_type._ros_type,
            node=node.get_fully_qualified_name(),
            on_goal=lambda goal: self._queue.append(("goal", goal)),
            on_cancel=lambda goal: self._queue.append(("cancel", goal)),
            copy=copy_message,
        )
        node.add_waitable(self)

    action_type = property(attrgetter("_action_type"), doc="The action's class.")

    def register_handle_accepted_callback(self, callback: Callable[[Any], Any] | None) -> None:
        """Call `callback` with the handle of each goal that was accepted."""
        self._handle_accepted_callback = callback or default_handle_accepted_callback

    def register_goal_callback(self, goal_callback: Callable[[Any], Any] | None) -> None:
        """Use `goal_callback` to decide on each goal: a GoalResponse."""
        self._goal_callback = goal_callback or default_goal_callback

    def register_cancel_callback(self, cancel_callback: Callable[[Any], Any] | None) -> None:
        """Use `cancel_callback` to decide on each cancel request: a CancelResponse."""
        self._cancel_callback = cancel_callback or default_cancel_callback

    def register_execute_callback(self, execute_callback: Callable[[Any], Any]) -> None:
        """Use `execute_callback` to pursue each goal, and return its result.

        Raises:
            TypeError: it cannot be called.
        """
        if not callable(execute_callback):
            raise TypeError("Failed to register goal execution callback: not callable")
        self._execute_callback = execute_callback

    def __enter__(self) -> Handle:
        return self.handle.__enter__()

    def __exit__(self, *error: object) -> None:
        self.handle.__exit__(*error)

    def get_num_entities(self) -> NumberOfEntities:
        """Return how many entities of each kind a server is made of."""
        return NumberOfEntities(num_timers=1, num_services=3)

    def destroy(self) -> None:
        """Stop serving."""
        super().destroy()
        self._end.close()
        self._node.remove_waitable(self)

    @property
    def _goal_handles(self) -> dict[bytes, ServerGoalHandle]:
        """The goals that the server knows, by their numbers."""
        self._forget_old()
        return {bytes(handle.goal_id.uuid): handle for handle in self._handles.values()}

    def _forget_old(self) -> None:
        """Forget the goals that have been over for `result_timeout`."""
        now_ns = run().scheduler.now_ns
        for key, handle in list(self._handles.items()):
            ended_ns = handle._ended_ns
            if ended_ns is not None and now_ns - ended_ns >= self._result_timeout_ns:
                del self._handles[key]

    def _is_ready(self) -> bool:
        return bool(self._queue)

    def _take(self, executor: Any) -> Call | None:
        if not self._queue:
            return None
        kind, goal = self._queue.popleft()
        decide = self._decide_goal if kind == "goal" else self._decide_cancel

        async def call() -> None:
            await decide(goal)

        return call

    async def _decide_goal(self, goal: ActionGoal) -> None:
        if goal.state is not GoalState.PENDING:
            return
        self._forget_old()
        request = copy_message(goal.message)
        response = await await_or_execute(self._goal_callback, request)
        if not isinstance(response, GoalResponse):
            self._node.get_logger().warning(
                "Goal request callback did not return a GoalResponse type. Rejecting goal."
            )
        if response is not GoalResponse.ACCEPT:
            goal.reject()
            return
        handle = self._handles[id(goal)] = ServerGoalHandle(self, goal, request)
        goal.accept(executing=False)
        await await_or_execute(self._handle_accepted_callback, handle)

    async def _decide_cancel(self, goal: ActionGoal) -> None:
        handle = self._handles.get(id(goal))
        if handle is None or not handle.is_active:
            return
        response = await await_or_execute(self._cancel_callback, handle)
        if response is CancelResponse.ACCEPT:
            try:
                goal.accept_cancel()
            except GoalStateError:
                self._node.get_logger().debug("the goal ended before it could be cancelled")
        else:
            # The client learns that nothing comes of its request.
            goal.is_cancel_asked = False
            goal.on_change(goal)

    def _notify_execute(
        self, handle: ServerGoalHandle, execute_callback: Callable[[Any], Any] | None
    ) -> None:
        executor = self._node.executor
        if executor is None:
            raise RuntimeError("the goal cannot be executed: nothing spins the node")
        executor._create_callback_task(
            self._execute, execute_callback or self._execute_callback, handle
        )

    def _no_result(self, given: Any) -> Exception:
        """Return the error of an execute callback that returned something else than a result.

        The real library sends what it got: where it is made a message of, that fails.
        """
        kind = self._action_type.Result
        if run().runtime.distro.value("field-of-wrong-type") == "AssertionError":
            text = f"The 'result' field must be a sub message of type '{kind.__name__}'"
            return AssertionError(text)
        fields = kind.get_fields_and_field_types()
        lacking = next((name for name in fields if not hasattr(given, name)), "_check_fields")
        return AttributeError(f"'{type(given).__name__}' object has no attribute '{lacking}'")

    async def _execute(self, callback: Callable[[Any], Any], handle: ServerGoalHandle) -> None:
        logger = self._node.get_logger()
        try:
            result = await await_or_execute(callback, handle)
        except Exception as error:  # noqa: BLE001 - the controller's; the server goes on
            result = self._action_type.Result()
            callback_failed("the execute callback of an action server", error)
            logger.error(f"Error raised in execute callback: {error}")
            traceback.print_exc()
        if handle.is_active:
            logger.warning("Goal state not set, assuming aborted.")
            handle._end = GoalState.ABORTED
        if not isinstance(result, self._action_type.Result):
            raise self._no_result(result)
        handle._send(result)
        handle._ended_ns = run().scheduler.now_ns


__all__ = _defined(globals())
