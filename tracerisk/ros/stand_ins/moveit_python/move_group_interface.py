"""Moves of a group by the action of move_group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import actionlib
import rospy
from geometry_msgs.msg import PoseStamped
from moveit_msgs.msg import Constraints, MoveGroupAction, MoveGroupGoal
from tf.listener import TransformListener

from tracerisk.ros.moveit import messages

__all__ = ["MoveGroupInterface"]

_TAKEN = ("max_velocity_scaling_factor", "planner_id", "planning_time", "plan_only", "start_state")


class MoveGroupInterface:
    """Plans and executes moves of a group, in a frame."""

    def __init__(
        self,
        group: str,
        frame: str,
        listener: Any = None,
        plan_only: bool = False,
        move_group: str = "move_group",
    ) -> None:
        self._group = group
        self._fixed_frame = frame
        self._action = actionlib.SimpleActionClient(move_group, MoveGroupAction)
        self._action.wait_for_server()
        self._listener = TransformListener() if listener is None else listener
        self.plan_only = plan_only
        self.planner_id: str | None = None
        self.planning_time = 15.0

    def get_move_action(self) -> Any:
        """Return the client of the action."""
        return self._action

    def moveToJointPosition(
        self,
        joints: Sequence[str],
        positions: Sequence[float],
        tolerance: float = 0.01,
        wait: bool = True,
        **kwargs: Any,
    ) -> Any:
        """Move to joint positions; return the MoveGroupResult, None without waiting."""
        _report_unknown("moveToJointPosition", kwargs, (*_TAKEN, "planning_scene_diff"))
        constraints = Constraints()
        constraints.joint_constraints = [
            messages.joint_constraint(joint, position, tolerance)
            for joint, position in zip(joints, positions, strict=False)
        ]
        return self._move(constraints, wait, kwargs)

    def moveToPose(
        self,
        pose_stamped: Any,
        gripper_frame: str,
        tolerance: float = 0.01,
        wait: bool = True,
        **kwargs: Any,
    ) -> Any:
        """Bring a link to a pose; return the MoveGroupResult, None without waiting."""
        _report_unknown("moveToPose", kwargs, _TAKEN)
        pose: PoseStamped = self._listener.transformPose(self._fixed_frame, pose_stamped)
        given = (self._fixed_frame, gripper_frame)
        # The radius is squared in the library.
        place = messages.position_constraint(*given, pose.pose, tolerance * tolerance)
        turn = messages.orientation_constraint(*given, pose.pose.orientation, (tolerance,) * 3)
        constraints = Constraints(position_constraints=[place], orientation_constraints=[turn])
        return self._move(constraints, wait, kwargs)

    def _move(self, constraints: Any, wait: bool, given: dict[str, Any]) -> Any:
        goal = MoveGroupGoal()
        request, options = goal.request, goal.planning_options
        if "start_state" in given:
            request.start_state = given["start_state"]
        else:
            request.start_state.is_diff = True
        request.goal_constraints.append(constraints)
        request.planner_id = given.get("planner_id", self.planner_id) or ""
        request.group_name = self._group
        request.num_planning_attempts = given.get("num_attempts", 1)
        request.allowed_planning_time = given.get("planning_time", self.planning_time)
        if "max_velocity_scaling_factor" in given:
            request.max_velocity_scaling_factor = given["max_velocity_scaling_factor"]
        if "planning_scene_diff" in given:
            options.planning_scene_diff = given["planning_scene_diff"]
        else:
            options.planning_scene_diff.is_diff = True
            options.planning_scene_diff.robot_state.is_diff = True
        options.plan_only = given.get("plan_only", self.plan_only)
        self._action.send_goal(goal)
        if not wait:
            return None
        self._action.wait_for_result()
        return self._action.get_result()

    def setPlannerId(self, planner_id: str) -> None:
        """Set the planner of later requests."""
        self.planner_id = str(planner_id)

    def setPlanningTime(self, time: float) -> None:
        """Set the planning time of later requests [s]."""
        self.planning_time = time


def _report_unknown(name: str, given: dict[str, Any], taken: Sequence[str]) -> None:
    for argument in given:
        if argument not in taken:
            rospy.loginfo(f"{name}: unsupported argument: {argument}")
