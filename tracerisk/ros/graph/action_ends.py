"""The two ends of an action: who serves it, and who sends goals."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Need, asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.action_goal import ActionGoal, ignore

if TYPE_CHECKING:
    from tracerisk.ros.graph.actions import Actions


@dataclass(slots=True, eq=False)
class ActionServerEnd:
    """The server of an action."""

    actions: Actions
    """The actions of the run."""
    name: str
    """The full name of the action."""
    type_name: str
    """The type of the action, `package/Name`."""
    node: str
    """The full name of the node that serves it."""
    on_goal: Callable[[ActionGoal], None]
    """The function that receives a goal."""
    on_cancel: Callable[[ActionGoal], None]
    """The function that receives a request to cancel a goal."""
    copy: Callable[[Any], Any]
    """The function that makes the message to send from a given result or feedback."""
    by_controller: bool
    """Whether the controller's code serves it; False for the twin and a scenario."""
    is_scenario: bool = False
    """Whether a scenario serves it."""
    place: Location | None = None
    """The line of the controller that made it; `None` where it is not the controller's."""
    is_called: bool = False
    """Whether a goal was ever sent to it."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for all others."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    on_message: Callable[[ActionGoal, str, Any], None] = ignore
    """The function for each `state` or `feedback` that a client received."""
    goals: list[ActionGoal] = field(default_factory=list)
    """The goals that are not over, in the order of sending."""
    closed: bool = False
    """Whether it has stopped serving."""

    @property
    def is_companions(self) -> bool:
        """Whether a node beside the controller serves it."""
        return self.process is not None

    def forget(self, goal: ActionGoal) -> None:
        """Keep a goal that is over no longer."""
        if goal in self.goals:
            self.goals.remove(goal)

    def close(self) -> None:
        """Stop serving; goals on their way stay as they are."""
        if not self.closed:
            self.closed = True
            self.actions._remove_server(self)


@dataclass(slots=True, eq=False)
class ActionClientEnd:
    """The client of an action, which sends goals."""

    actions: Actions
    """The actions of the run."""
    name: str
    """The full name of the action."""
    type_name: str
    """The type of the action, `package/Name`."""
    node: str
    """The full name of the node that sends goals."""
    copy: Callable[[Any], Any]
    """The function that makes the message to send from a given goal."""
    closed: bool = False
    """Whether it has been closed."""
    place: Location | None = field(default_factory=asking_place)
    """The line of the controller that made it; `None` where none is known."""
    by_controller: bool = True
    """Whether the controller's code sends the goals; False for a client of the twin."""
    made_ns: int = 0
    """The simulated time at which it was made [ns]."""
    process: NodeProcess | None = None
    """The node beside the controller that it belongs to; `None` for the controller's own."""
    _numbers: Any = field(default_factory=lambda: itertools.count(1))
    """The numbers of its goals, from 1."""

    @property
    def server(self) -> ActionServerEnd | None:
        """Who serves the action with the client's type, if anybody that is connected."""
        server = self._known_server
        if server is None or self._connected_ns(server) > self.actions.scheduler.now_ns:
            return None
        return server

    @property
    def _known_server(self) -> ActionServerEnd | None:
        """Who serves the action with the client's type, connected or not yet."""
        return self.actions.server(self.name, self.type_name)

    def _connected_ns(self, server: ActionServerEnd) -> int:
        """When it is connected to a server [ns]."""
        carrier = self.actions.carrier
        if not self.by_controller:
            return 0
        if not server.by_controller:
            return carrier.connected_ns(self.name, self.made_ns, "action client")
        made_ns = max(self.made_ns, server.made_ns)
        return carrier.own_connected_ns(
            made_ns, "subscriber", is_within=self.process is server.process
        )

    def _is_away(self, server: ActionServerEnd) -> bool:
        return self.by_controller and not server.by_controller

    def is_served(self) -> bool:
        """Return whether somebody serves the action, as the controller asks it."""
        if self.server is None:
            self._miss(f"a question for action server {self.name}")
            return False
        self._found()
        return True

    def _miss(self, what: str, content: object = None) -> None:
        """Note that the controller asked for a server that is not there, or not found yet."""
        if self._known_server is None:
            self.actions.scheduler.miss(self._need)
        else:
            self.actions.scheduler.needs.meet(self._need)
            self.actions.carrier.note_early(what, self.name, "action client", content)

    def _found(self, content: object = None) -> None:
        self.actions.scheduler.needs.meet(self._need)
        self.actions.carrier.note_in_time(self.name, content)

    def wait_for_server(
        self, timeout_ns: int | None = None, unless: Callable[[], bool] = lambda: False
    ) -> bool:
        """Wait until somebody serves the action, and return whether somebody does.

        False after the timeout (None waits for ever), or as soon as `unless` holds.

        Raises:
            RunOver: the run is over; a wait that nothing can end is a deadlock that names the
                action, its type and where the controller waits.
        """
        self.actions.scheduler.wait_until(
            lambda: self.server is not None or unless(),
            timeout_ns=timeout_ns,
            reason=f"action server {self.name} ({self.type_name})",
            kind="unmet",
            need=self._need,
        )
        return self.is_served()

    def send(
        self,
        message: Any,
        *,
        goal_id: Any = None,
        on_change: Callable[[ActionGoal], None] = ignore,
        on_feedback: Callable[[ActionGoal, Any], None] = ignore,
        data: Any = None,
    ) -> ActionGoal:
        """Send a goal, with the stack of the running code; it stays PENDING where nobody serves.

        Without `goal_id` it is `node-number`.

        Raises:
            RunOver: the run is over.
        """
        scheduler = self.actions.scheduler
        scheduler.count_call()
        scheduler.raise_if_over()
        number = next(self._numbers)
        server = self.server
        if server is None:
            self._miss(f"a goal of {self.name}", message)
        else:
            self._found(message)
        goal = ActionGoal(
            f"{self.node}-{number}" if goal_id is None else goal_id,
            self,
            server,
            self.copy(message),
            self.actions.stack(),
            scheduler.now_ns,
            scheduler.bound(on_change),
            scheduler.bound(on_feedback),
            data=data,
        )
        self.actions.count_goal(goal)
        if server is not None:
            server.is_called = True
            server.goals.append(goal)
            goal.is_on_way = True
            self.actions.carrier.carry(goal.arrive, self.name, is_away=self._is_away(server))
        return goal

    @property
    def _need(self) -> Need:
        return Need("action", self.name, self.type_name)

    def cancel_all(self) -> None:
        """Ask the server to cancel every goal it has, whoever sent it."""
        self.cancel_sent_until(None)

    def cancel_sent_until(self, time_ns: int | None) -> None:
        """Ask the server to cancel every goal that was sent until `time_ns` (None: all)."""
        server = self.server
        if server is None:
            return
        for goal in tuple(server.goals):
            if not goal.state.is_terminal and (time_ns is None or goal.sent_ns <= time_ns):
                goal.ask_cancel()

    def close(self) -> None:
        """Leave the action; goals on their way go on."""
        if not self.closed:
            self.closed = True
            self.actions._remove_client(self)
