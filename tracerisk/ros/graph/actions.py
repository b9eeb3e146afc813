"""Actions in one process: who serves them, and the goals on their way.

Neither version of ROS is meant: actionlib and rclpy.action give their own classes, threads and
queues to what is here, and the twin serves through it. A goal carries the stack of the code that
sent it, so that what a server makes of it is owned by the sender.

What is passed from one end to the other arrives at once, as a call of the other end's hook, which
must not wait: a client library queues what runs code of the controller.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.graph.action_ends import ActionClientEnd, ActionServerEnd
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.failures import answer_failed
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

    def note_answer(self, goal: ActionGoal) -> None:
        """Record the end of a goal of the controller's that another serves, where it is a failure.

        One that was cancelled on request is none.
        """
        server = goal.server
        if goal.client.by_controller and server is not None and not server.by_controller:
            has_failed = goal.state in (GoalState.ABORTED, GoalState.REJECTED, GoalState.LOST)
            answer_failed(goal.client.name, goal.result, goal.stack, has_failed=has_failed)

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
