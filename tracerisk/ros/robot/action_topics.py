"""The topics of ROS 1 actions, for programs that publish goals and read results themselves.

An action of ROS 1 is five topics: `goal` and `cancel` to its server, `status`, `feedback` and
`result` from it. Clients of actionlib need none of them here; what they send is published too.
"""

from __future__ import annotations

from typing import Any

from tracerisk.ros.graph.action_ends import ActionClientEnd
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import ActionChange, Actions
from tracerisk.ros.graph.graph import Change
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.robot.bring_up.system import SystemState
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.time.clock import EPOCH_NS

STATUS_HZ = 5.0
"""How often a server publishes the status of its goals besides at changes, as in actionlib [Hz]."""
KEPT_S = 5.0
"""How long the status of a goal is published after its end, as by actionlib's servers [s]."""

_STATUS = "actionlib_msgs/GoalStatusArray"
_GOAL_ID = "actionlib_msgs/GoalID"
_REPORTED = {"status": _STATUS, "feedback": "ActionFeedback", "result": "ActionResult"}


class ActionTopics(TwinNode):
    """Sends what is published on `goal` and `cancel`, and publishes what servers report."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._actions = runtime.client(Actions)
        self._clients: dict[str, ActionClientEnd] = {}
        self._publications: dict[str, Publication] = {}
        self._sent_by_topic: set[str] = set()
        self._goals: dict[str, dict[ActionGoal, int | None]] = {}
        self._ticking: set[str] = set()
        self._graph.watch(self._on_topic)
        self._actions.watch(self._on_action)

    def _on_topic(self, change: Change, name: str, type_name: str) -> None:
        action, _, leaf = name.rpartition("/")
        if change == "subscribed" and type_name.endswith(_REPORTED.get(leaf, " ")):
            self._serve_if_of_bring_up(action)
            self._report_status(action)
        if change != "advertised" or action in self._clients:
            return
        if leaf == "goal" and type_name.endswith("ActionGoal"):
            kind = type_name.removesuffix("ActionGoal")
            self._sent_by_topic.add(action)
            self._clients[action] = self._actions.client(
                action, kind, node=self.node, by_controller=False
            )
            self._hear(name, type_name, lambda message, _: self._send(action, message))
            self._hear(
                f"{action}/cancel", _GOAL_ID, lambda message, _: self._cancel(action, message)
            )
            self._offer_reports(action, kind)

    def _serve_if_of_bring_up(self, action: str) -> None:
        """Serve an action that the bring-up has, for who listens and sends no goal."""
        if action in self._goals or action in self._clients:
            return
        for name, kind, _ in self._runtime.client(SystemState).actions():
            if name == action:
                client = self._actions.client(name, kind, node=self.node, by_controller=False)
                client.place = None

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
            server.on_message = self._pass_on
            self._goals.setdefault(name, {})
            self._offer_reports(name, type_name)
            self._report_status(name)

    def _offer_reports(self, action: str, kind: str) -> None:
        """Publish what a server reports of goals sent by topic: who sends looks for it before."""
        if action in self._goals and action in self._sent_by_topic:
            self._publication(f"{action}/feedback", f"{kind}ActionFeedback")
            self._publication(f"{action}/result", f"{kind}ActionResult")

    def _pass_on(self, goal: ActionGoal, what: str, message: Any) -> None:
        name, kind = goal.client.name, goal.client.type_name
        if what == "feedback":
            self._publish(f"{name}/feedback", f"{kind}ActionFeedback", goal, "feedback", message)
            return
        if goal.state.is_terminal:
            result = goal.result if goal.result is not None else self._messages.part(kind, "Result")
            self._publish(f"{name}/result", f"{kind}ActionResult", goal, "result", result)
        ended_ns = self._scheduler.now_ns if goal.state.is_terminal else None
        self._goals.setdefault(name, {})[goal] = ended_ns
        if self._graph.subscriptions(f"{name}/status"):
            self._publish_status(name)

    def _report_status(self, action: str) -> None:
        """Publish the status of an action's goals, now and again, while somebody subscribes."""
        if action not in self._goals or action in self._ticking:
            return
        if not self._graph.subscriptions(f"{action}/status"):
            return
        self._ticking.add(action)
        self._go_on(action)

    def _go_on(self, action: str) -> None:
        if not self._graph.subscriptions(f"{action}/status"):
            self._ticking.discard(action)
            return
        self._publish_status(action)
        due_ns = self._scheduler.now_ns + round(1e9 / STATUS_HZ)
        self._scheduler.call_at(due_ns, lambda: self._go_on(action), background=True)

    def _publish_status(self, action: str) -> None:
        now_ns = self._scheduler.now_ns
        goals = self._goals[action] = {
            goal: ended_ns
            for goal, ended_ns in self._goals[action].items()
            if ended_ns is None or now_ns - ended_ns <= KEPT_S * 1e9
        }
        array = self._messages.new(_STATUS)
        self._messages.stamp(array.header, now_ns)
        array.status_list = [self._status(goal) for goal in goals]
        self._publication(f"{action}/status", _STATUS, latch=True).publish(array)

    def _publish(self, topic: str, kind: str, goal: ActionGoal, field: str, part: Any) -> None:
        if not self._graph.subscriptions(topic):
            return
        message = self._messages.new(kind)
        self._now(message.header)
        message.status = self._status(goal)
        setattr(message, field, part)
        self._publication(topic, kind).publish(message)

    def _status(self, goal: ActionGoal) -> Any:
        status = self._messages.new("actionlib_msgs/GoalStatus")
        status.goal_id.id = str(goal.id)
        set_time(status.goal_id.stamp, EPOCH_NS + goal.sent_ns)
        status.status, status.text = goal.state.ros1_status, goal.text
        return status

    def _publication(self, topic: str, type_name: str, *, latch: bool = False) -> Publication:
        if topic not in self._publications:
            self._publications[topic] = self._graph.advertise(
                topic, type_name, node=self.node, latch=latch, by_controller=False
            )
        return self._publications[topic]
