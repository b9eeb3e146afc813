"""The actions of a Niryo arm: moves, and its tool.

Source: NiryoRobotics/ned_ros, niryo_robot_arm_commander/action, niryo_robot_tools_commander/action
and the numbers of niryo_robot_msgs/CommandStatus.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.niryo.motion import NiryoMotion
from tracerisk.ros.vendors.niryo.places import NiryoPlaces
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import PlanningError

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

ROBOT_MOVE = "niryo_robot_arm_commander/RobotMove"
TOOL = "niryo_robot_tools_commander/Tool"

_SUCCESS, _PREEMPTED, _STOPPED, _CONTROLLER_PROBLEMS = 1, 3, -4, -223
_TOOL_FAILURE, _INVALID = -251, -52
STATUS_OF = {
    "invalid_goal": _INVALID,
    "bad_request": _INVALID,
    "no_ik_solution": -232,
    "no_plan": -230,
    "collision": -226,
    "start_in_collision": -226,
}
"""The status of each way in which planning fails."""

_OPEN, _CLOSE = 1, 2
_DONE = "Command has been successfully processed"


class NiryoActions(NiryoPlaces):
    """Carries out goals; a new one of the arm takes the place of the one before."""

    node = "/niryo_robot_arm_commander"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._arm = ArmMotion(self._commands, ("tool_link",))
        self._motion = NiryoMotion(self._arm)
        self._is_stopped = False

    def _stop_goal(self) -> None:
        """Stop the arm; its goal ends as stopped."""
        self._is_stopped = True
        self._arm.stop()
        self._is_stopped = False

    def move(self, goal: ActionGoal) -> None:
        """Take a goal of RobotMove."""
        goal.accept()
        try:
            trajectory = self._motion.trajectory(goal.message.cmd, self._scheduler.now_ns)
            if trajectory is None:
                goal.succeed(self._result(ROBOT_MOVE, _SUCCESS, "Command was already satisfied"))
                return
            self._arm.start(
                "niryo_move", trajectory, goal.stack, partial(self._end, goal), goal=goal
            )
        except PlanningError as error:
            self._commands.report(
                "goal_rejected", f"a move of the arm was aborted: {error.message}", goal.stack
            )
            status = STATUS_OF[error.failure]
            goal.abort(self._result(ROBOT_MOVE, status, error.message), error.message)

    def _end(self, goal: ActionGoal, motion: Motion) -> None:
        if goal.state.is_terminal:
            return
        if motion.outcome == "succeeded":
            goal.succeed(self._result(ROBOT_MOVE, _SUCCESS, _DONE))
        elif motion.outcome == "aborted":
            goal.abort(self._result(ROBOT_MOVE, _CONTROLLER_PROBLEMS, motion.message))
        else:
            status = _STOPPED if self._is_stopped else _PREEMPTED
            goal.cancel(self._result(ROBOT_MOVE, status, "Command has been stopped"))

    def use_tool(self, goal: ActionGoal) -> None:
        """Take a goal of Tool: grippers open and close; another tool is one that the twin lacks."""
        goal.accept()
        asked = goal.message.cmd
        if asked.cmd_type not in (_OPEN, _CLOSE) or self._arm.gripper is None:
            kind = "gripper" if asked.cmd_type in (_OPEN, _CLOSE) else "pump or electromagnet"
            self._commands.report(
                "unprovided",
                f"tool {asked.tool_id} is asked for cmd_type {asked.cmd_type}, and the twin has no "
                f"{kind}: what it would hold is not in the run; serve the action in a scenario",
                goal.stack,
                object_name=goal.client.name,
            )
            goal.succeed(self._result(TOOL, _SUCCESS, _DONE))
            return
        motion = self._arm.move_gripper(float(asked.cmd_type == _OPEN), goal.stack, goal=goal)
        self._scheduler.spawn(
            lambda: self._end_tool(goal, motion), "niryo tool", inherit=False, is_controllers=False
        )

    def _end_tool(self, goal: ActionGoal, motion: Motion) -> None:
        self._arm.wait(motion)
        if goal.state.is_terminal:
            return
        statuses = {"succeeded": _SUCCESS, "preempted": _PREEMPTED}
        status = statuses.get(motion.outcome, _TOOL_FAILURE)
        text = _DONE if status == _SUCCESS else motion.message
        goal.end(motion.outcome, self._result(TOOL, status, text))

    def _result(self, action: str, status: int, message: str) -> Any:
        result = self._messages.part(action, "Result")
        result.status, result.message = status, message
        return result
