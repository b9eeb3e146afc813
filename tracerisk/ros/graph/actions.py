"""Actions in one process: who serves them, and the goals on their way.

Neither version of ROS is meant: actionlib and rclpy.action give their own classes, threads and
queues to what is here, and the twin serves through it. A goal carries the stack of the code that
sent it, so that what a server makes of it is owned by the sender.

What is passed from one end to the other arrives at once, as a call of the other end's hook, which
must not wait: a client library queues what runs code of the controller.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.action_goal import ActionGoal, ignore
from tracerisk.ros.graph.runtime import Runtime

ActionChange = Literal["client", "client_gone", "served", "unserved"]
# The topics of ROS 1 on which the two sides publish, with their types.
_OF_CLIENTS = {"goal": "{}ActionGoal", "cancel": "actionlib_msgs/GoalID"}
_OF_SERVERS = {
    "feedback": "{}ActionFeedback",
    "result": "{}ActionResult",
    "status": "actionlib_msgs/GoalStatusArray",
}


def topics_of_action(name: str, type_name: str) -> tuple[tuple[str, str, bool], ...]:
    """Return the topics of an action of ROS 1: name, type, and whether its server publishes it."""
    leaves = (*_OF_CLIENTS.items(), *_OF_SERVERS.items())
    return tuple(
        (f"{name}/{leaf}", kind.format(type_name), leaf in _OF_SERVERS) for leaf, kind in leaves
    )


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


class Actions:
    """The actions of one run: `runtime.client(Actions)`.

    Several servers may have been made under one name; the controller's own comes before a
    scenario's, that before the twin's, and of two the later one.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self.scheduler = runtime.scheduler
        self.carrier = runtime.graph.carrier
        self._runtime = runtime
        self._servers: dict[str, list[ActionServerEnd]] = {}
        self._clients: dict[str, list[ActionClientEnd]] = {}
        self._watchers: list[Callable[[ActionChange, str, str], None]] = []
        self.when_cancelled_late: list[Callable[[ActionGoal], None]] = []
        """What is called with a goal that was over when it was to be cancelled."""
        graph_listens = self.scheduler.listens
        self.scheduler.listens = lambda: graph_listens() or self._listens()

    def count_goal(self, goal: ActionGoal) -> None:
        """Count a goal that the controller sent."""
        cell = self._runtime.graph.count(goal.client.name)
        if cell is not None:
            cell.sent(goal)

    def note_late_cancel(self, goal: ActionGoal) -> None:
        """Pass on that a goal was to be cancelled that was over."""
        for call in self.when_cancelled_late:
            call(goal)

    def _listens(self) -> bool:
        return any(
            action_server_end.by_controller
            for known in self._servers.values()
            for action_server_end in known
        )

    def watch(self, watcher: Callable[[ActionChange, str, str], None]) -> None:
        """Call `watcher` with change, name and type when a client or a server comes or goes.

        It is called at once with all that exist already.
        """
        self._watchers.append(watcher)
        for clients in list(self._clients.values()):
            for client in clients:
                watcher("client", client.name, client.type_name)
        for servers in list(self._servers.values()):
            for server in servers:
                watcher("served", server.name, server.type_name)

    def serve(
        self,
        name: str,
        type_name: str,
        *,
        node: str,
        on_goal: Callable[[ActionGoal], None],
        on_cancel: Callable[[ActionGoal], None],
        copy: Callable[[Any], Any] = lambda message: message,
        by_controller: bool = True,
        is_scenario: bool = False,
    ) -> ActionServerEnd:
        """Serve an action of a type: `control_msgs/FollowJointTrajectory`."""
        if by_controller:
            on_goal = self.scheduler.bound(on_goal, asks=True)
            on_cancel = self.scheduler.bound(on_cancel)
        server = ActionServerEnd(
            self, name, type_name, node, on_goal, on_cancel, copy, by_controller, is_scenario
        )
        server.place = asking_place() if by_controller else None
        server.process = self.scheduler.process if by_controller else None
        server.made_ns = self.carrier.made_ns(by_controller=by_controller)
        self._servers.setdefault(name, []).append(server)
        for client in self._clients.get(name, ()):
            self._wake_when_connected(client)
        self._report("served", name, type_name)
        return server

    def client(
        self,
        name: str,
        type_name: str,
        *,
        node: str,
        copy: Callable[[Any], Any] = lambda message: message,
        by_controller: bool = True,
    ) -> ActionClientEnd:
        """Become a client of an action; the twin serves it then, if its type is one of its own."""
        client = ActionClientEnd(self, name, type_name, node, copy, by_controller=by_controller)
        client.made_ns = self.carrier.made_ns(by_controller=by_controller)
        client.process = self.scheduler.process if by_controller else None
        self._clients.setdefault(name, []).append(client)
        self._report("client", name, type_name)
        self._wake_when_connected(client)
        return client

    def _wake_when_connected(self, client: ActionClientEnd) -> None:
        """Wake who waits for the server when the client is connected to it."""
        server = client._known_server
        if server is not None:
            due_ns = client._connected_ns(server)
            self.carrier.expect(due_ns)
            if due_ns > self.scheduler.now_ns:
                self.scheduler.call_at(due_ns, lambda: None)

    def server(self, name: str, type_name: str) -> ActionServerEnd | None:
        """Return who serves an action of a type: the controller, else a scenario, else the twin."""
        fitting = [
            action_server_end
            for action_server_end in self._servers.get(name, ())
            if action_server_end.type_name == type_name
        ]
        own = [
            action_server_end for action_server_end in fitting if action_server_end.by_controller
        ]
        candidates = (
            own
            or [action_server_end for action_server_end in fitting if action_server_end.is_scenario]
            or fitting
        )
        return candidates[-1] if candidates else None

    def unserved(self) -> tuple[Missed, ...]:
        """Return the actions of which the controller has a client and that nobody serves."""
        return tuple(
            Missed(action_client_end._need, 0, 0, action_client_end.place)
            for known in self._clients.values()
            for action_client_end in known
            if action_client_end.place is not None and action_client_end._known_server is None
        )

    def uncalled(self) -> tuple[Missed, ...]:
        """Return the controller's own servers to which nobody has sent a goal."""
        return tuple(
            Missed(
                Need("goal", action_server_end.name, action_server_end.type_name),
                0,
                0,
                action_server_end.place,
            )
            for known in self._servers.values()
            for action_server_end in known
            if action_server_end.by_controller
            and not action_server_end.is_companions
            and not action_server_end.is_called
        )

    def names_and_types(self) -> tuple[tuple[str, str], ...]:
        """Return name and type of every action that has a client or a server, sorted."""
        ends: tuple[ActionServerEnd | ActionClientEnd, ...] = (*self.servers(), *self.clients())
        return tuple(sorted({(end.name, end.type_name) for end in ends}))

    def published_topics(self) -> set[tuple[str, str]]:
        """Return name and type of the topics that clients and servers publish in ROS 1."""
        sides: tuple[tuple[tuple[Any, ...], bool], ...] = (
            (self.clients(), False),
            (self.servers(), True),
        )
        return {
            (topic, kind)
            for ends, are_servers in sides
            for end in ends
            for topic, kind, is_servers in topics_of_action(end.name, end.type_name)
            if is_servers is are_servers
        }

    def clients(self) -> tuple[ActionClientEnd, ...]:
        """Return all clients, in the order of their names."""
        return tuple(end for _, ends in sorted(self._clients.items()) for end in ends)

    def servers(self) -> tuple[ActionServerEnd, ...]:
        """Return all servers, in the order of their names."""
        return tuple(end for _, ends in sorted(self._servers.items()) for end in ends)

    def stack(self) -> tuple[Any, ...]:
        """Return the stack of the running code: whoever sends a goal owns what comes of it."""
        tracer: Any = self._runtime.tracer
        return () if tracer is None else tuple(tracer.stack())

    def _remove_server(self, server: ActionServerEnd) -> None:
        self._servers[server.name].remove(server)
        self._report("unserved", server.name, server.type_name)

    def _remove_client(self, client: ActionClientEnd) -> None:
        self._clients[client.name].remove(client)
        self._report("client_gone", client.name, client.type_name)

    def _report(self, change: ActionChange, name: str, type_name: str) -> None:
        for watcher in tuple(self._watchers):
            watcher(change, name, type_name)
