"""Topics of the actions by which MoveIt of ROS 1 executes, for programs that listen to these.

`go` and `execute` of moveit_commander are goals of `/move_group` and `/execute_trajectory`, and
MoveIt sends each trajectory as a goal to the controller of its joints. Where no client of an action
sent the goal, it is made here, so that its status, feedback and result are published as well.
Sources: moveit/moveit moveit_ros/planning_interface/move_group_interface/src/
move_group_interface.cpp; moveit_plugins/moveit_simple_controller_manager/include/
moveit_simple_controller_manager/follow_joint_trajectory_controller_handle.h.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.action_ends import ActionClientEnd
from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.moveit.trajectory_execution import ErrorCode, Execution, TrajectoryExecution
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_ACTIONS = {
    "move_action": ("/move_group", "moveit_msgs/MoveGroup"),
    "execute_trajectory": ("/execute_trajectory", "moveit_msgs/ExecuteTrajectory"),
}
_FOLLOW = "control_msgs/FollowJointTrajectory"
_HEARD = ("status", "feedback", "result")


class ExecutionReports(TwinNode):
    """Makes a goal of each action that an execution goes through, and ends it as that ends."""

    node = "/move_group"

    def __init__(
        self, runtime: Runtime, messages: TwinMessages, execution: TrajectoryExecution
    ) -> None:
        super().__init__(runtime, messages)
        self._actions = runtime.client(Actions)
        self._clients: dict[str, ActionClientEnd] = {}
        self._goals: dict[Execution, list[ActionGoal]] = {}
        self._numbers = itertools.count(1)
        execution.on_begin, execution.on_end = self._begin, self._end
        execution.on_refused = self._refused

    def _begin(self, execution: Execution, *, is_of_goal: bool) -> None:
        if not self._has_listeners():
            return
        asked = _ACTIONS.get(execution.by) if not is_of_goal else None
        names = [] if asked is None else [asked]
        names += [
            (f"/{name}/follow_joint_trajectory", _FOLLOW) for name in self._controllers(execution)
        ]
        goals = [self._goal(name, kind) for name, kind in names]
        self._goals[execution] = [goal for goal in goals if goal is not None]
        for goal in self._goals[execution]:
            goal.accept("This goal has been accepted by the simple action server")

    def _end(self, execution: Execution) -> None:
        code = ErrorCode.FAILURE if execution.code is None else execution.code
        for goal in reversed(self._goals.pop(execution, [])):
            goal.end(execution.motion.outcome, self._result(goal, code))

    def _refused(self, code: ErrorCode) -> None:
        """Report a goal of `/move_group` that came to no motion."""
        goal = self._goal(*_ACTIONS["move_action"])
        if goal is not None:
            goal.accept()
            goal.abort(self._result(goal, code))

    def _controllers(self, execution: Execution) -> list[str]:
        states, moved = self._runtime.client(ControllerStates), {*execution.motion.joints}
        return sorted(
            name
            for name in states.running
            if "Trajectory" in states.all[name].type and moved & {*states.all[name].joints}
        )

    def _has_listeners(self) -> bool:
        """Return whether somebody listens to any action: most programs do not."""
        return any(
            self._graph.subscriptions(topic)
            for topic in self._graph.topic_names()
            if topic.rpartition("/")[2] in _HEARD
        )

    def _goal(self, name: str, kind: str) -> ActionGoal | None:
        """Return a goal of an action of the twin to whose topics somebody listens."""
        if not any(self._graph.subscriptions(f"{name}/{leaf}") for leaf in _HEARD):
            return None
        if name not in self._clients:
            client = self._actions.client(name, kind, node=self.node, by_controller=False)
            client.place = None
            self._clients[name] = client
        client = self._clients[name]
        server = client.server
        if server is None or server.by_controller or server.is_scenario:
            return None
        now_ns = self._scheduler.now_ns
        return ActionGoal(f"{self.node}-{next(self._numbers)}", client, server, None, (), now_ns)

    def _result(self, goal: ActionGoal, code: ErrorCode) -> Any:
        result = self._messages.part(goal.client.type_name, "Result")
        if goal.client.type_name != _FOLLOW:
            result.error_code.val = int(code)
        return result
