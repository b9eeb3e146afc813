"""The client that follows any number of goals, and the state of each as the client sees it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from rospy.rostime import duration_ns
from std_msgs.msg import Header

from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.callback_thread import CallbackThread
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.exported import defined as _defined
from tracerisk.ros.messages.ros1_base import SerializationError
from tracerisk.ros.time.clock import EPOCH_NS

from ._node import action_name, action_parts, call_back, is_shut_down, sent
from .exceptions import ActionException  # noqa: F401 - names of this module too
from .goal_id_generator import GoalIDGenerator

_FOR_EVER = rospy.Duration()


def get_name_of_constant(C: Any, n: int) -> str:
    """Return the name of the constant of class `C` whose value is `n`."""
    for name, value in C.__dict__.items():
        if type(value) is int and value == n:
            return str(name)
    return f"NO_SUCH_STATE_{n}"


class CommState:
    """What the client knows of a goal."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7
    LOST = 8

    to_string = classmethod(get_name_of_constant)


class TerminalState:
    """How a goal can end."""

    RECALLED = GoalStatus.RECALLED
    REJECTED = GoalStatus.REJECTED
    PREEMPTED = GoalStatus.PREEMPTED
    ABORTED = GoalStatus.ABORTED
    SUCCEEDED = GoalStatus.SUCCEEDED
    LOST = GoalStatus.LOST

    to_string = classmethod(get_name_of_constant)


GoalStatus.to_string = classmethod(get_name_of_constant)

_UNHEARD = (CommState.WAITING_FOR_GOAL_ACK,)
_UNTAKEN = (CommState.WAITING_FOR_GOAL_ACK, CommState.PENDING)
_ENDING_EARLY = (CommState.WAITING_FOR_CANCEL_ACK, CommState.RECALLING)


def _way(state: int, status: int) -> list[int]:
    """Return the states through which a goal passes when a status comes, WAITING_FOR_RESULT last.

    A status that was missed is made up for: a goal that is SUCCEEDED was ACTIVE before.
    """
    way: list[int] = []
    if status in (GoalStatus.PENDING, GoalStatus.REJECTED):
        if state in _UNHEARD:
            way = [CommState.PENDING]
    elif status == GoalStatus.ACTIVE:
        if state in _UNTAKEN:
            way = [CommState.ACTIVE]
    elif status in (GoalStatus.RECALLING, GoalStatus.RECALLED):
        if state in _UNHEARD:
            way = [CommState.PENDING]
        if state not in (CommState.RECALLING, *_UNHEARD) or status == GoalStatus.RECALLING:
            way = [*way, CommState.RECALLING] if state != CommState.RECALLING else way
    else:
        if state in _UNTAKEN:
            way = [CommState.ACTIVE]
        preempts = status in (GoalStatus.PREEMPTING, GoalStatus.PREEMPTED)
        if (preempts or state in _ENDING_EARLY) and state != CommState.PREEMPTING:
            way = [*way, CommState.PREEMPTING]
    if status in _TERMINAL and state != CommState.WAITING_FOR_RESULT:
        way.append(CommState.WAITING_FOR_RESULT)
    return way


_TERMINAL = (
    GoalStatus.PREEMPTED,
    GoalStatus.SUCCEEDED,
    GoalStatus.ABORTED,
    GoalStatus.REJECTED,
    GoalStatus.RECALLED,
    GoalStatus.LOST,
)


class CommStateMachine:
    """One goal as the client sees it; `action_goal` is the message that was sent."""

    def __init__(
        self,
        action_goal: Any,
        transition_cb: Callable[[ClientGoalHandle], object] | None,
        feedback_cb: Callable[[ClientGoalHandle, Any], object] | None,
        send_goal_fn: Callable[[Any], object] | None = None,
        send_cancel_fn: Callable[[Any], object] | None = None,
    ) -> None:
        self.action_goal = action_goal
        self.transition_cb = transition_cb
        self.feedback_cb = feedback_cb
        self.send_goal_fn = send_goal_fn
        self.send_cancel_fn = send_cancel_fn
        self.state = CommState.WAITING_FOR_GOAL_ACK
        self.mutex = threading.RLock()
        self.latest_goal_status = GoalStatus(status=GoalStatus.PENDING)
        self.latest_result: Any = None

    def update(self, status: Any, result: Any) -> None:
        """Take a status of the server; a terminal one comes with its result."""
        if self.state == CommState.DONE:
            return
        self.latest_goal_status = status
        way = _way(self.state, status.status)
        if status.status in _TERMINAL:
            self.latest_result = result
        for state in way:
            self.transition_to(state)
        if status.status in _TERMINAL:
            self.transition_to(CommState.DONE)

    def update_feedback(self, action_feedback: Any) -> None:
        """Take a feedback of the server."""
        if self.feedback_cb is not None and self.state != CommState.DONE:
            self.feedback_cb(ClientGoalHandle(self), action_feedback)

    def transition_to(self, state: int) -> None:
        """Go to a state and call the transition callback."""
        self.state = state
        if self.transition_cb is not None:
            self.transition_cb(ClientGoalHandle(self))


class ClientGoalHandle:
    """A goal that was sent; two handles are equal where they follow the same goal."""

    def __init__(self, comm_state_machine: CommStateMachine) -> None:
        self.comm_state_machine = comm_state_machine

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, ClientGoalHandle)
            and self.comm_state_machine is other.comm_state_machine
        )

    def __hash__(self) -> int:
        return hash(self.comm_state_machine.action_goal.goal_id.id)

    def cancel(self) -> None:
        """Ask the server to end the goal early."""
        machine = self.comm_state_machine
        cancel = GoalID(stamp=rospy.Time(0), id=machine.action_goal.goal_id.id)
        if machine.send_cancel_fn is not None:
            machine.send_cancel_fn(cancel)
        machine.transition_to(CommState.WAITING_FOR_CANCEL_ACK)

    def get_comm_state(self) -> int:
        """Return the goal's `CommState`."""
        current().scheduler.touch()
        return self.comm_state_machine.state

    def get_goal_status(self) -> int:
        """Return the last status that came from the server."""
        current().scheduler.touch()
        return int(self.comm_state_machine.latest_goal_status.status)

    def get_goal_status_text(self) -> str:
        """Return the text of the last status."""
        current().scheduler.touch()
        return str(self.comm_state_machine.latest_goal_status.text)

    def get_result(self) -> Any:
        """Return the result, or None where none has come."""
        current().scheduler.touch()
        return self.comm_state_machine.latest_result

    def get_terminal_state(self) -> int:
        """Return how the goal ended; LOST, with an error logged, where it has not."""
        machine = self.comm_state_machine
        if machine.state != CommState.DONE:
            rospy.logwarn(
                "Asking for the terminal state when we're in [%s]",
                CommState.to_string(machine.state),
            )
        status = int(machine.latest_goal_status.status)
        if status in _TERMINAL:
            return status
        rospy.logerr("Asking for a terminal state, but the goal status is %d", status)
        return int(GoalStatus.LOST)


class ActionClient:
    """Send goals to the action `ns` of type `ActionSpec`, and follow each by its handle.

    Raises:
        ActionException: `ActionSpec` is not an action's message, such as `FibonacciAction`.
    """

    def __init__(self, ns: str, ActionSpec: Any) -> None:
        self.ns = ns
        self.ActionSpec = ActionSpec
        parts = action_parts(ActionSpec)
        self.ActionGoal, self.ActionResult, self.ActionFeedback = parts.wrappers
        run = current()
        self._name = action_name(ns)
        self._end = run.client(Actions).client(
            self._name, parts.type_name, node=rospy.get_name(), copy=lambda goal: goal
        )
        self._generator = GoalIDGenerator()
        self._transitions = CallbackThread(run.scheduler, run.tracer, f"action client {self._name}")
        self._feedback = CallbackThread(run.scheduler, run.tracer, f"feedback of {self._name}")
        self._sent: dict[str, ActionGoal] = {}
        self._over: ActionGoal | None = None

    def send_goal(
        self,
        goal: Any,
        transition_cb: Callable[[ClientGoalHandle], object] | None = None,
        feedback_cb: Callable[[ClientGoalHandle, Any], object] | None = None,
    ) -> ClientGoalHandle:
        """Send a goal and return its handle; callbacks run on threads of the client.

        Raises:
            ROSException: the node is not initialized.
            ROSSerializationException: a field of the goal holds what its type cannot take.
        """
        if not rospy.core.is_initialized():
            raise rospy.ROSException(
                "ROS node has not been initialized yet. Please call init_node() first"
            )
        goal_id = self._generator.generate_ID()
        action_goal = self.ActionGoal(Header(stamp=goal_id.stamp), goal_id, goal)
        try:
            message = sent(action_goal)
        except SerializationError as error:
            raise rospy.ROSSerializationException(str(error)) from error
        machine = CommStateMachine(action_goal, transition_cb, feedback_cb, None, self._send_cancel)
        self._sent[goal_id.id] = self._end.send(
            message.goal,
            goal_id=goal_id.id,
            on_change=lambda sent_goal: self._changed(machine, sent_goal),
            on_feedback=lambda _, feedback: self._fed_back(machine, feedback),
        )
        return ClientGoalHandle(machine)

    def cancel_all_goals(self) -> None:
        """Ask the server to end all its goals early, those of other clients too."""
        self._end.cancel_all()

    def cancel_goals_at_and_before_time(self, time: Any) -> None:
        """Ask the server to end early the goals that were sent until `time`."""
        self._end.cancel_sent_until(time.to_nsec() - EPOCH_NS)

    def wait_for_server(self, timeout: Any = _FOR_EVER) -> bool:
        """Wait until somebody serves the action, for ever with a zero timeout.

        Raises:
            TypeError: the timeout is not a Duration.
        """
        # The real one adds it to the present time, which takes nothing but a Duration.
        _ = rospy.get_rostime() + timeout
        timeout_ns = duration_ns(timeout)
        wait = self._end.wait_for_server(
            timeout_ns if timeout_ns > 0 else None, unless=is_shut_down
        )
        return wait and not is_shut_down()

    def stop(self) -> None:
        """Leave the action."""
        self._transitions.close()
        self._feedback.close()
        self._end.close()

    @property
    def words(self) -> str:
        """The action's name and type, for messages."""
        return f"{self._name} ({self._end.type_name})"

    def is_served(self) -> bool:
        """Return whether somebody serves the action now."""
        return self._end.is_served()

    def _send_cancel(self, cancel: Any) -> None:
        goal = self._sent.get(cancel.id, self._over)
        if goal is not None and goal.id == cancel.id:
            goal.ask_cancel()

    def _changed(self, machine: CommStateMachine, goal: ActionGoal) -> None:
        status = GoalStatus(machine.action_goal.goal_id, goal.state.ros1_status, goal.text)
        result = goal.result
        is_over = goal.state.is_terminal
        if is_over:
            self._over = self._sent.pop(goal.id, None)
        tracer: Any = current().tracer

        def update() -> None:
            root: Any = nullcontext()
            if is_over:
                # Feedback that was published before the result is heard before it.
                self._feedback.give_turn()
                if tracer is not None:
                    root = tracer.root("done_callback")
            with root:
                call_back(lambda: machine.update(status, result), self._name)

        self._transitions.put(update)

    def _fed_back(self, machine: CommStateMachine, feedback: Any) -> None:
        self._feedback.put(lambda: call_back(lambda: machine.update_feedback(feedback), self._name))


__all__ = _defined(globals(), "ActionException", "GoalID", "GoalStatus", "Header")
