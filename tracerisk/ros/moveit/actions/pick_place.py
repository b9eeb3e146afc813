"""The actions Pickup and Place of MoveIt 1, carried out as its commander's pick and place."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.trajectory_execution import Asker, ErrorCode
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PICKUP, PLACE = "moveit_msgs/Pickup", "moveit_msgs/Place"


class PickPlaceServer(TwinNode):
    """Picks and places for whoever sends a goal; the steps belong to the sender's code."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._server = runtime.client(MoveGroupServer)
        self._latest: dict[Asker, ActionGoal] = {}

    def pickup(self, goal: ActionGoal) -> None:
        """Pick the target by the first of the grasps that works."""
        self._begin(goal, self._pick)

    def place(self, goal: ActionGoal) -> None:
        """Place the attached object at the first of the locations that works."""
        self._begin(goal, self._put)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Bring the robot to rest; the goal ends with the step that goes on."""
        goal.accept_cancel()
        self._server.execution.stop(self._asker(goal))

    def _begin(self, goal: ActionGoal, carry_out: Callable[[Any], int]) -> None:
        """Carry out a goal; one of the same action that goes on ends with its present step."""
        asker = self._asker(goal)
        before = self._latest.get(asker)
        self._latest[asker] = goal
        if before is not None and not before.state.is_terminal:
            self._server.execution.give_way(asker)
        goal.accept()

        def run() -> None:
            from moveit_commander import MoveItCommanderException

            if before is not None:
                self._scheduler.wait_until(
                    lambda: before.state.is_terminal, reason=f"a goal of {before.client.name}"
                )
            try:
                code = carry_out(goal.message)
            except MoveItCommanderException:
                # The group cannot: it has no tip, or none of that name is there.
                code = int(ErrorCode.INVALID_GROUP_NAME)
            result = self._messages.part(goal.client.type_name, "Result")
            result.error_code.val = code
            if goal.is_cancel_asked or code == ErrorCode.PREEMPTED:
                goal.cancel(result)
            elif code == ErrorCode.SUCCESS:
                goal.succeed(result)
            else:
                goal.abort(result, f"MoveIt error {code}")

        # On the stack of the code that sent the goal, whose thread goes on.
        self._scheduler.spawn(run, f"goal of {goal.client.name}", is_controllers=False)

    @staticmethod
    def _asker(goal: ActionGoal) -> Asker:
        return "pickup" if goal.client.type_name == PICKUP else "place"

    def _pick(self, asked: Any) -> int:
        options = asked.planning_options
        grasps = list(asked.possible_grasps)
        return int(self._group(asked).pick(asked.target_name, grasps, bool(options.plan_only)))

    def _put(self, asked: Any) -> int:
        options = asked.planning_options
        locations = list(asked.place_locations)
        group = self._group(asked)
        is_done = group.place(asked.attached_object_name, locations, bool(options.plan_only))
        return int(ErrorCode.SUCCESS if is_done else ErrorCode.PLANNING_FAILED)

    def _group(self, asked: Any) -> Any:
        # The commander that the controller itself would get; it is served inside a run only.
        from moveit_commander import MoveGroupCommander

        groups = self._twin.robot.groups
        largest = max(groups, key=lambda name: len(groups[name].joints))
        name = asked.group_name if asked.group_name in groups else largest
        return MoveGroupCommander(name)
