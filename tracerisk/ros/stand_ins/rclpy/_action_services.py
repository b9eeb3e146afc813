"""The services and topics of an action, for programs that call or hear them themselves.

An action of ROS 2 is three services, `send_goal`, `cancel_goal` and `get_result`, and two topics,
`feedback` and `status`, below `NAME/_action`. Clients and servers of rclpy need none of them here;
they are there as soon as a program asks for one by its name, whoever serves the action.
"""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from unique_identifier_msgs.msg import UUID

from tracerisk.ros.graph.action_ends import ActionClientEnd
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.actions import ActionChange
from tracerisk.ros.graph.services import ServiceServer
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.time.clock import EPOCH_NS

from ._node_entities import OF_ACTION

_SECOND = 1_000_000_000
_KEPT_NS = 10 * _SECOND
"""How long a goal that is over is still reported [ns]: the default of servers."""
_NO_ID = bytes(16)


class ActionServices:
    """Serves and publishes what programs have asked for below `NAME/_action`."""

    def __init__(self, run: Any) -> None:
        self._graph = run.graph
        self._actions = run.actions
        self._scheduler = run.scheduler
        self._asked: dict[str, dict[str, Any]] = {}
        self._served: dict[str, list[ServiceServer]] = {}
        self._clients: dict[str, ActionClientEnd] = {}
        self._goals: dict[str, dict[bytes, ActionGoal]] = {}
        self._over_ns: dict[bytes, int] = {}
        self._publications: dict[str, Publication] = {}
        self._actions.watch(self._on_action)

    def ask(self, name: str, kind: Any) -> None:
        """Provide a service or topic of an action, of the class `kind`, while the action is served.

        Names that are none of an action are left alone.
        """
        action, mark, leaf = name.partition(OF_ACTION)
        if mark and leaf in ("send_goal", "cancel_goal", "get_result", "feedback", "status"):
            self._asked.setdefault(action, {})[leaf] = kind
            self._provide(action)

    # Who serves the action

    def _on_action(self, change: ActionChange, name: str, type_name: str) -> None:
        if name not in self._asked:
            return
        if change == "served":
            self._provide(name)
        elif change == "unserved" and not self._servers(name):
            for server in self._served.pop(name, ()):
                server.close()

    def _servers(self, action: str) -> list[Any]:
        return [server for server in self._actions.servers() if server.name == action]

    def _provide(self, action: str) -> None:
        servers = self._servers(action)
        if not servers:
            return
        handlers = {
            "send_goal": self._send_goal,
            "cancel_goal": self._cancel_goal,
            "get_result": self._get_result,
        }
        known = {server.name for server in self._served.get(action, ())}
        for leaf, kind in self._asked[action].items():
            name = f"{action}{OF_ACTION}{leaf}"
            if leaf not in handlers:
                self._publish_on(name, kind)
            elif name not in known:
                self._served.setdefault(action, []).append(
                    self._graph.services.serve(
                        name,
                        kind._ros_type,
                        lambda request, handler=handlers[leaf], kind=kind: handler(
                            action, request, kind.Response()
                        ),
                        node=servers[-1].node,
                        is_callback=False,
                    )
                )
        for server in servers:
            if getattr(server.on_message, "__self__", None) is not self:
                server.on_message = _Both(self, server.on_message)

    # What is called

    def _send_goal(self, action: str, request: Any, response: Any) -> Any:
        goals, number = self._goals_of(action), bytes(request.goal_id.uuid)
        if number in goals:
            # A number that is known already is refused.
            return response
        if action not in self._clients:
            server = self._servers(action)[-1]
            self._clients[action] = self._actions.client(
                action, server.type_name, node=server.node, copy=server.copy, by_controller=False
            )
        goal = goals[number] = self._clients[action].send(request.goal, goal_id=number)
        self._scheduler.wait_until(
            lambda: goal.state is not GoalState.PENDING,
            reason=f"the answer of action server {action}",
            kind="unmet",
        )
        response.accepted = goal.state is not GoalState.REJECTED
        response.stamp = _stamp(response.stamp, self._scheduler.now_ns)
        return response

    def _cancel_goal(self, action: str, request: Any, response: Any) -> Any:
        number = bytes(request.goal_info.goal_id.uuid)
        stamp = request.goal_info.stamp
        until_ns = stamp.sec * _SECOND + stamp.nanosec - EPOCH_NS
        goals = self._goals_of(action)
        if number != _NO_ID and number not in goals:
            response.return_code = CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
            return response
        is_all = number == _NO_ID and until_ns == -EPOCH_NS
        chosen = [
            goal
            for key, goal in goals.items()
            if is_all or key == number or goal.sent_ns <= until_ns
        ]
        living = [goal for goal in chosen if not goal.state.is_terminal]
        for goal in living:
            goal.ask_cancel()
            self._scheduler.wait_until(
                lambda goal=goal: (
                    goal.state.is_cancelling or goal.state.is_terminal or not goal.is_cancel_asked
                ),
                reason=f"the answer of action server {action} to a cancel",
                kind="unmet",
            )
        response.goals_canceling = [_info(goal) for goal in living if goal.state.is_cancelling]
        if not response.goals_canceling:
            response.return_code = (
                CancelGoal.Response.ERROR_GOAL_TERMINATED
                if number != _NO_ID and not living
                else CancelGoal.Response.ERROR_REJECTED
            )
        return response

    def _get_result(self, action: str, request: Any, response: Any) -> Any:
        goal = self._goals_of(action).get(bytes(request.goal_id.uuid))
        if goal is None:
            response.status = GoalStatus.STATUS_UNKNOWN
            return response
        self._scheduler.wait_until(
            lambda: goal.state.is_terminal,
            reason=f"the result of a goal of {action}",
            kind="unmet",
        )
        response.status = goal.state.ros2_status
        if goal.result is not None:
            response.result = goal.result
        return response

    # What is published

    def _publish_on(self, topic: str, kind: Any) -> None:
        if topic not in self._publications:
            self._publications[topic] = self._graph.advertise(
                topic,
                kind._ros_type,
                node="",
                latch=topic.endswith("status"),
                by_controller=False,
            )

    def publish(self, goal: ActionGoal, what: str, message: Any) -> None:
        """Publish what a server has reported of a goal."""
        action, number = goal.client.name, _number(goal)
        self._goals_of(action)[number] = goal
        asked = self._asked.get(action, {})
        if what == "feedback" and "feedback" in asked:
            self._publications[f"{action}{OF_ACTION}feedback"].publish(
                asked["feedback"](goal_id=UUID(uuid=list(number)), feedback=message)
            )
        elif what == "state":
            if goal.state.is_terminal:
                self._over_ns.setdefault(number, self._scheduler.now_ns)
            if "status" in asked:
                self._publications[f"{action}{OF_ACTION}status"].publish(
                    GoalStatusArray(
                        status_list=[
                            GoalStatus(
                                goal_info=_info(action_goal), status=action_goal.state.ros2_status
                            )
                            for action_goal in self._goals_of(action).values()
                            if action_goal.state not in (GoalState.PENDING, GoalState.REJECTED)
                        ]
                    )
                )

    def _goals_of(self, action: str) -> dict[bytes, ActionGoal]:
        """Return the goals that are reported; those that have been over for long are forgotten."""
        goals = self._goals.setdefault(action, {})
        for number in [goal for goal in goals if goal in self._over_ns]:
            if self._scheduler.now_ns - self._over_ns[number] >= _KEPT_NS:
                del goals[number], self._over_ns[number]
        return goals


class _Both:
    """Notifies the services of an action, after whoever was notified before."""

    def __init__(self, services: ActionServices, other: Any) -> None:
        self._services = services
        self._other = other
        self.__self__ = services

    def __call__(self, goal: ActionGoal, what: str, message: Any) -> None:
        self._other(goal, what, message)
        self._services.publish(goal, what, message)


def _number(goal: ActionGoal) -> bytes:
    return goal.id if isinstance(goal.id, bytes) else _NO_ID


def _info(goal: ActionGoal) -> Any:
    made = GoalInfo(goal_id=UUID(uuid=list(_number(goal))))
    made.stamp = _stamp(made.stamp, goal.sent_ns)
    return made


def _stamp(stamp: Any, time_ns: int) -> Any:
    stamp.sec, stamp.nanosec = divmod(EPOCH_NS + time_ns, _SECOND)
    return stamp
