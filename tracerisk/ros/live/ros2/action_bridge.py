"""The actions of the twin's graph as real ROS 2 sees them: goals, their states and results.

A goal has a number of the relay's, which holds the handle that real ROS gave it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.errors import InputError
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.actions import ActionChange, Actions
from tracerisk.ros.messages.ros2_wire import decode, encode

if TYPE_CHECKING:
    from tracerisk.ros.graph.action_ends import ActionClientEnd
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.ros.live.link import Link


class ActionBridge:
    """Serves in real ROS the actions of which the controller has a client and the twin a server.

    `interfaces` make the classes of messages; `say_once` gets a name, and in words why its action
    is not served.
    """

    def __init__(
        self, runtime: Runtime, interfaces: Any, relay: Link, say_once: Callable[[str, str], None]
    ) -> None:
        self._actions = runtime.client(Actions)
        self._interfaces, self._relay, self._say_once = interfaces, relay, say_once
        self._clients: dict[str, ActionClientEnd] = {}
        self._served: set[str] = set()
        self._own: set[str] = set()
        self._goals: dict[int, ActionGoal] = {}
        self._cancels: set[int] = set()
        self._answered: set[int] = set()
        self._actions.watch(self._on_change)

    def client(self, name: str, type_name: str, node: str) -> None:
        """Note that the controller has a client of an action."""
        if name in self._own or name in self._clients:
            return
        try:
            self._interfaces.action(type_name)
        except InputError as error:
            self._say_once(name, f"action {name} stays out of the twin: {error.message}")
            return
        self._clients[name] = self._actions.client(name, type_name, node=node)
        self._offer(name)

    def goal_class(self, name: str) -> Any:
        """Return the class of the goals of an action; None where the twin does not serve it."""
        client = self._clients.get(name)
        return None if client is None else self._interfaces.action(client.type_name).Goal

    def serves(self, name: str) -> None:
        """Note that the controller serves an action itself: the twin leaves it to it."""
        self._own.add(name)
        client = self._clients.pop(name, None)
        if client is not None:
            client.close()
        if name in self._served:
            self._served.discard(name)
            self._relay.send({"do": "close", "name": name})

    def take(self, header: dict[str, Any], body: bytes) -> None:
        """Take a goal, or the request to cancel one, as the running code sent it."""
        number = header["number"]
        if header["is"] == "cancel":
            self._cancel(number)
            return
        client = self._clients.get(header["name"])
        if client is None or client.server is None:
            self._answer(number, ok=False)
            return
        message = decode(body, self._interfaces.action(client.type_name).Goal)
        # Its server may answer before `send` has returned it.
        client.send(
            message,
            goal_id=number.to_bytes(16, "big"),
            on_change=partial(self._changed, number),
            on_feedback=partial(self._fed_back, number),
        )

    def _on_change(self, change: ActionChange, name: str, type_name: str) -> None:
        del type_name
        if change == "served" and name in self._clients:
            self._offer(name)

    def _offer(self, name: str) -> None:
        client = self._clients[name]
        if name in self._served or client.server is None:
            return
        self._served.add(name)
        self._relay.send({"do": "act", "name": name, "type": client.type_name})

    def _cancel(self, number: int) -> None:
        goal = self._goals.get(number)
        if goal is None or goal.state.is_terminal:
            self._answer(number, ok=False, do="cancel_answer")
            return
        self._cancels.add(number)
        goal.ask_cancel()
        if number in self._cancels and not goal.is_cancel_unread:
            self._answer_cancel(number, ok=goal.state.is_cancelling)

    def _changed(self, number: int, goal: ActionGoal) -> None:
        state = goal.state
        self._goals[number] = goal
        if number not in self._answered and state is not GoalState.PENDING:
            self._answered.add(number)
            self._answer(number, ok=state is not GoalState.REJECTED)
            if state is GoalState.REJECTED:
                return
        if number in self._cancels and (state.is_cancelling or state.is_terminal):
            self._answer_cancel(number, ok=state.is_cancelling)
        header = {"do": "state", "number": number, "state": state.name}
        if not state.is_terminal:
            self._relay.send(header)
            return
        result = goal.result
        if result is None:
            result = self._interfaces.action(goal.client.type_name).Result()
        self._relay.send(header, encode(result))
        del self._goals[number]

    def _fed_back(self, number: int, goal: ActionGoal, message: Any) -> None:
        del goal
        self._relay.send({"do": "feedback", "number": number}, encode(message))

    def _answer_cancel(self, number: int, *, ok: bool) -> None:
        self._cancels.discard(number)
        self._answer(number, ok=ok, do="cancel_answer")

    def _answer(self, number: int, *, ok: bool, do: str = "goal_answer") -> None:
        self._relay.send({"do": do, "number": number, "ok": ok})
