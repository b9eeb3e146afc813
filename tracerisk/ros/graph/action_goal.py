"""The goal of an action: its states, and what server and client may do with it."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from tracerisk.ros.graph.action_ends import ActionClientEnd, ActionServerEnd


class GoalState(enum.Enum):
    """What a goal has come to, as its server says.

    ROS 1 knows no ACCEPTED (its goals are ACTIVE at once), ROS 2 neither RECALLING nor RECALLED
    nor LOST; REJECTED has a response but no status in ROS 2.
    """

    PENDING = "pending"
    ACCEPTED = "accepted"
    ACTIVE = "active"
    RECALLING = "recalling"
    PREEMPTING = "preempting"
    REJECTED = "rejected"
    RECALLED = "recalled"
    PREEMPTED = "preempted"
    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    LOST = "lost"

    @property
    def is_terminal(self) -> bool:
        """Whether nothing follows."""
        return self in _TERMINAL

    @property
    def is_cancelling(self) -> bool:
        """Whether a cancel was granted: it ends the goal, or has ended it."""
        return self in _CANCELLING

    @property
    def ros1_status(self) -> int:
        """The number of the state in actionlib_msgs/GoalStatus."""
        return _STATUS[self][0]

    @property
    def ros2_status(self) -> int:
        """The number of the state in action_msgs/GoalStatus."""
        return _STATUS[self][1]


_TERMINAL = frozenset(
    {
        GoalState.REJECTED,
        GoalState.RECALLED,
        GoalState.PREEMPTED,
        GoalState.SUCCEEDED,
        GoalState.ABORTED,
        GoalState.LOST,
    }
)
_CANCELLING = frozenset(
    {GoalState.PREEMPTING, GoalState.PREEMPTED, GoalState.RECALLING, GoalState.RECALLED}
)
_STATUS = {
    GoalState.PENDING: (0, 0),
    GoalState.ACCEPTED: (1, 1),
    GoalState.ACTIVE: (1, 2),
    GoalState.PREEMPTED: (2, 5),
    GoalState.SUCCEEDED: (3, 4),
    GoalState.ABORTED: (4, 6),
    GoalState.REJECTED: (5, 6),
    GoalState.PREEMPTING: (6, 3),
    GoalState.RECALLING: (7, 3),
    GoalState.RECALLED: (8, 5),
    GoalState.LOST: (9, 0),
}
"""The number of each state in actionlib_msgs/GoalStatus, and in action_msgs/GoalStatus."""
PURSUED = (GoalState.ACCEPTED, GoalState.ACTIVE, GoalState.PREEMPTING)
LIVE = (*PURSUED, GoalState.PENDING, GoalState.RECALLING)


def ignore(*_message: Any) -> None:
    """Do nothing with a message."""
    del _message


class GoalStateError(Exception):
    """A server asked for a step that the goal's state does not allow."""


@dataclass(slots=True, eq=False)
class ActionGoal:
    """A goal from the moment it was sent."""

    id: Any
    """The identifier that the client library gave it, or `node-number`."""
    client: ActionClientEnd
    """The end that sent it."""
    server: ActionServerEnd | None
    """The end that serves it; `None` where nobody does."""
    message: Any
    """The goal message as it was sent."""
    stack: tuple[Any, ...]
    """The stack of the code that sent it."""
    sent_ns: int
    """The simulated time at which it was sent [ns]."""
    on_change: Callable[[ActionGoal], None] = ignore
    """The client library's function for each change of state."""
    on_feedback: Callable[[ActionGoal, Any], None] = ignore
    """The client library's function for each feedback."""
    state: GoalState = GoalState.PENDING
    """The present state, as the server reports it."""
    text: str = ""
    """The server's text on the state."""
    result: Any = None
    """The result message; `None` before a terminal state, or where the server gave none."""
    is_cancel_asked: bool = False
    """Whether the client has asked to cancel it."""
    is_cancel_unread: bool = False
    """Whether the server reads a request to cancel only after the goal's end."""
    is_on_way: bool = False
    """Whether it has not reached the server yet."""
    data: Any = None
    """Free for the server."""
    motion: Any = None
    """The motion that the twin executes for it; `None` where it moves nothing."""

    # The server's side; `is_on_way` until the goal has come there

    def accept(self, text: str = "", *, executing: bool = True) -> None:
        """Take the goal; it is ACTIVE, or ACCEPTED until `execute` where not `executing`.

        Raises:
            GoalStateError: the goal does not wait to be taken.
        """
        self._expect("accept", GoalState.PENDING, GoalState.RECALLING)
        if self.state is GoalState.RECALLING:
            self._become(GoalState.PREEMPTING, text)
        else:
            self._become(GoalState.ACTIVE if executing else GoalState.ACCEPTED, text)

    def execute(self) -> None:
        """Begin the work of an accepted goal.

        Raises:
            GoalStateError: the goal is not merely accepted.
        """
        self._expect("execute", GoalState.ACCEPTED)
        self._become(GoalState.ACTIVE, self.text)

    def reject(self, text: str = "", result: Any = None) -> None:
        """Refuse the goal.

        Raises:
            GoalStateError: the goal does not wait to be taken.
        """
        self._expect("reject", GoalState.PENDING, GoalState.RECALLING)
        self._become(GoalState.REJECTED, text, result)

    def accept_cancel(self, text: str = "") -> None:
        """Agree to end the goal early: RECALLING or PREEMPTING.

        Raises:
            GoalStateError: the goal is over or ends already.
        """
        self._expect("cancel", GoalState.PENDING, GoalState.ACCEPTED, GoalState.ACTIVE)
        is_pending = self.state is GoalState.PENDING
        self._become(GoalState.RECALLING if is_pending else GoalState.PREEMPTING, text)

    def cancel(self, result: Any = None, text: str = "") -> None:
        """End the goal early: RECALLED where it was not taken yet, else PREEMPTED.

        Raises:
            GoalStateError: the goal is over.
        """
        self._expect("set canceled", *LIVE)
        untaken = self.state in (GoalState.PENDING, GoalState.RECALLING)
        self._become(GoalState.RECALLED if untaken else GoalState.PREEMPTED, text, result)

    def succeed(self, result: Any = None, text: str = "") -> None:
        """End the goal as reached.

        Raises:
            GoalStateError: the goal is not being pursued, or its motion did not arrive.
        """
        self._expect("set succeeded", *PURSUED)
        if self.motion is not None and self.motion.outcome != "succeeded":
            raise GoalStateError(
                f"cannot set succeeded a goal of {self.client.name} whose motion is "
                f"{self.motion.outcome}; end it as its motion ended"
            )
        self._become(GoalState.SUCCEEDED, text, result)

    def abort(self, result: Any = None, text: str = "") -> None:
        """End the goal as failed.

        Raises:
            GoalStateError: the goal is not being pursued.
        """
        self._expect("set aborted", *PURSUED)
        self._become(GoalState.ABORTED, text, result)

    def end(self, outcome: str, result: Any = None, text: str = "") -> None:
        """End the goal as what it asked for ended: `succeeded`, `preempted`, or else failed.

        One that is over already is left alone.
        """
        if not self.state.is_terminal:
            ends = {"succeeded": self.succeed, "preempted": self.cancel}
            ends.get(outcome, self.abort)(result, text)

    def publish_feedback(self, feedback: Any) -> None:
        """Send feedback to the client."""
        copied = self._copied(feedback)
        self.on_feedback(self, copied)
        self._report("feedback", copied)

    # The client's side

    def ask_cancel(self) -> None:
        """Ask the server to end the goal early; it decides.

        A goal that is over, or ends early already, is left alone.
        """
        if self.state.is_terminal:
            self.client.actions.note_late_cancel(self)
            return
        if self.state in (GoalState.RECALLING, GoalState.PREEMPTING):
            return
        self.is_cancel_asked = True
        if not self.is_on_way:
            self._pass_on_cancel()

    def arrive(self) -> None:
        """Come to the server, and a request to cancel that was sent meanwhile after it."""
        self.is_on_way = False
        if self.server is not None and not self.server.closed:
            self.server.on_goal(self)
            if self.is_cancel_asked and not self.state.is_terminal:
                self._pass_on_cancel()

    def _pass_on_cancel(self) -> None:
        if self.server is not None and not self.server.closed:
            self.server.on_cancel(self)

    def _expect(self, step: str, *allowed: GoalState) -> None:
        if self.state not in allowed:
            names = ", ".join(state.name for state in allowed)
            raise GoalStateError(
                f"cannot {step} a goal of {self.client.name} that is {self.state.name}; "
                f"the goal must be one of {names}"
            )

    def _become(self, state: GoalState, text: str, result: Any = None) -> None:
        self.state, self.text = state, text
        if state.is_terminal:
            self.result = None if result is None else self._copied(result)
            if self.server is not None:
                self.server.forget(self)
                self.client.actions.note_answer(self)
        self.on_change(self)
        self._report("state", None)

    def _copied(self, message: Any) -> Any:
        return message if self.server is None else self.server.copy(message)

    def _report(self, what: Literal["feedback", "state"], message: Any) -> None:
        if self.server is not None:
            self.server.on_message(self, what, message)
