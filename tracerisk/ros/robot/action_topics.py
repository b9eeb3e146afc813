"""The topics of ROS 1 actions, for programs that publish goals and read results themselves.

An action of ROS 1 is five topics: `goal` and `cancel` to its server, `status`, `feedback` and
`result` from it. Clients of actionlib need none of them here; what they send is told all the same.
"""

from __future__ import annotations

from typing import Any

from tracerisk.ros.graph.actions import ActionChange, ActionClientEnd, ActionGoal, Actions
from tracerisk.ros.graph.graph import Change, Publication
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.time.clock import EPOCH_NS

_NODE = "/robot_driver"
_GOAL_ID = "actionlib_msgs/GoalID"


class ActionTopics:
    """Sends what is published on `goal` and `cancel`, and publishes what servers tell."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._runtime = runtime
        self._graph = runtime.graph
        self._actions = runtime.client(Actions)
        self._messages = messages
        self._clients: dict[str, ActionClientEnd] = {}
        self._publications: dict[str, Publication] = {}
        self._graph.watch(self._on_topic)
        self._actions.watch(self._on_action)

    def _on_topic(self, change: Change, name: str, type_name: str) -> None:
        action, _, leaf = name.rpartition("/")
        if change != "advertised" or action in self._clients:
            return
        if leaf == "goal" and type_name.endswith("ActionGoal"):
            kind = type_name.removesuffix("ActionGoal")
            self._clients[action] = self._actions.client(action, kind, node=_NODE)
            self._graph.subscribe(
                name,
                type_name,
                lambda message, _: self._send(action, message),
                node=_NODE,
                by_controller=False,
            )
            self._graph.subscribe(
                f"{action}/cancel",
                _GOAL_ID,
                lambda message, _: self._cancel(action, message),
                node=_NODE,
                by_controller=False,
            )

    def _send(self, action: str, message: Any) -> None:
        self._clients[action].send(message.goal, goal_id=message.goal_id.id or None)

    def _cancel(self, action: str, message: Any) -> None:
        client = self._clients[action]
        if not message.id:
            stamp_ns = message.stamp.to_nsec()
            client.cancel_sent_until(stamp_ns - EPOCH_NS if stamp_ns else None)
            return
        for goal in tuple(client.server.goals) if client.server is not None else ():
            if goal.id == message.id:
                goal.ask_cancel()

    def _on_action(self, change: ActionChange, name: str, type_name: str) -> None:
        server = self._actions.server(name, type_name)
        if change == "served" and server is not None:
            server.on_told = self._told

    def _told(self, goal: ActionGoal, what: str, message: Any) -> None:
        name, kind = goal.client.name, goal.client.type_name
        if what == "feedback":
            self._publish(f"{name}/feedback", f"{kind}ActionFeedback", goal, "feedback", message)
            return
        if goal.state.is_terminal:
            result = goal.result if goal.result is not None else self._messages.part(kind, "Result")
            self._publish(f"{name}/result", f"{kind}ActionResult", goal, "result", result)
        topic = f"{name}/status"
        if self._graph.subscriptions(topic):
            array = self._messages.new("actionlib_msgs/GoalStatusArray")
            self._messages.stamp(array.header, self._runtime.scheduler.now_ns)
            array.status_list = [self._status(goal)]
            self._publication(topic, "actionlib_msgs/GoalStatusArray").publish(array)

    def _publish(self, topic: str, kind: str, goal: ActionGoal, field: str, part: Any) -> None:
        if not self._graph.subscriptions(topic):
            return
        message = self._messages.new(kind)
        self._messages.stamp(message.header, self._runtime.scheduler.now_ns)
        message.status = self._status(goal)
        setattr(message, field, part)
        self._publication(topic, kind).publish(message)

    def _status(self, goal: ActionGoal) -> Any:
        status = self._messages.new("actionlib_msgs/GoalStatus")
        status.goal_id.id = str(goal.id)
        set_time(status.goal_id.stamp, EPOCH_NS + goal.sent_ns)
        status.status, status.text = goal.state.ros1_status, goal.text
        return status

    def _publication(self, topic: str, type_name: str) -> Publication:
        if topic not in self._publications:
            self._publications[topic] = self._graph.advertise(topic, type_name, node=_NODE)
        return self._publications[topic]
