"""Goals and path constraints of a request."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from geometry_msgs.msg import Pose
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints

from tracerisk.ros.moveit import messages

from ._messages import point, quaternion, stamped
from ._waiting import OnNode


class Goals(OnNode):
    """Gathers goals, joints, poses and constraints for the next plan."""

    def _begin_goals(
        self, joint_names: Sequence[str], base_link: str, end_effector: str, group: str
    ) -> None:
        self._joint_names = list(joint_names)
        self._base_link, self._end_effector, self._group = base_link, end_effector, group
        goal = self._goal = MoveGroup.Goal()
        request = goal.request
        request.workspace_parameters.header.frame_id = base_link
        for corner, size in (
            (request.workspace_parameters.min_corner, -1.0),
            (request.workspace_parameters.max_corner, 1.0),
        ):
            corner.x = corner.y = corner.z = size
        request.goal_constraints = [Constraints()]
        request.group_name = group
        request.num_planning_attempts = 5
        request.allowed_planning_time = 0.5
        request.max_velocity_scaling_factor = 0.0
        request.max_acceleration_scaling_factor = 0.0
        goal.planning_options.replan_attempts = 5
        goal.planning_options.replan = True
        goal.planning_options.replan_delay = 0.5

    def _stamped(self, pose: Any, position: Any, quat_xyzw: Any, frame_id: str | None) -> Any:
        frame = self._base_link if frame_id is None else frame_id
        now = self._node.get_clock().now().to_msg()
        return stamped(pose, position, quat_xyzw, frame, now)

    # Goals

    def set_pose_goal(
        self,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance_position: float = 0.001,
        tolerance_orientation: Any = 0.001,
        weight_position: float = 1.0,
        weight_orientation: float = 1.0,
    ) -> None:
        """Add a pose to the goal.

        Raises:
            ValueError: there is neither a pose nor both a position and a quaternion.
        """
        if pose is None and (position is None or quat_xyzw is None):
            raise ValueError("Either `pose` or `position` and `quat_xyzw` must be specified!")
        goal = self._stamped(pose, position, quat_xyzw, frame_id)
        frame = goal.header.frame_id
        self.set_position_goal(
            goal.pose.position, frame, target_link, tolerance_position, weight_position
        )
        self.set_orientation_goal(
            goal.pose.orientation, frame, target_link, tolerance_orientation, weight_orientation
        )

    def create_position_constraint(
        self,
        position: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> Any:
        """Return the constraint of a link to a sphere about a position."""
        frame, link = self._frame_and_link(frame_id, target_link)
        place = Pose(position=point(position))
        return messages.position_constraint(frame, link, place, float(tolerance), weight)

    def _frame_and_link(self, frame_id: str | None, target_link: str | None) -> tuple[str, str]:
        return (
            self._base_link if frame_id is None else frame_id,
            self._end_effector if target_link is None else target_link,
        )

    def set_position_goal(
        self,
        position: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> None:
        """Add a position to the goal."""
        self._goal.request.goal_constraints[-1].position_constraints.append(
            self.create_position_constraint(position, frame_id, target_link, tolerance, weight)
        )

    def create_orientation_constraint(
        self,
        quat_xyzw: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: Any = 0.001,
        weight: float = 1.0,
        parameterization: int = 0,
    ) -> Any:
        """Return the constraint of a link to an orientation; 0 for Euler angles, 1 for a vector."""
        tolerances = (tolerance,) * 3 if isinstance(tolerance, float | int) else tolerance
        constraint = messages.orientation_constraint(
            *self._frame_and_link(frame_id, target_link),
            quaternion(quat_xyzw),
            [float(each) for each in tolerances],
            weight,
        )
        constraint.parameterization = parameterization
        return constraint

    def set_orientation_goal(
        self,
        quat_xyzw: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: Any = 0.001,
        weight: float = 1.0,
        parameterization: int = 0,
    ) -> None:
        """Add an orientation to the goal."""
        self._goal.request.goal_constraints[-1].orientation_constraints.append(
            self.create_orientation_constraint(
                quat_xyzw, frame_id, target_link, tolerance, weight, parameterization
            )
        )

    def create_joint_constraints(
        self,
        joint_positions: Sequence[float],
        joint_names: Sequence[str] | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> list[Any]:
        """Return the constraints of joints, by default of the first of the arm's."""
        names = self._joint_names if joint_names is None else joint_names
        return [
            messages.joint_constraint(names[index], position, tolerance, weight)
            for index, position in enumerate(joint_positions)
        ]

    def set_joint_goal(
        self,
        joint_positions: Sequence[float],
        joint_names: Sequence[str] | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> None:
        """Add joint positions to the goal."""
        self._goal.request.goal_constraints[-1].joint_constraints.extend(
            self.create_joint_constraints(joint_positions, joint_names, tolerance, weight)
        )

    def clear_goal_constraints(self) -> None:
        """Forget the goal."""
        self._goal.request.goal_constraints = [Constraints()]

    def create_new_goal_constraint(self) -> None:
        """Begin another goal beside the ones before: one of them is to be reached."""
        self._goal.request.goal_constraints.append(Constraints())

    # Path constraints

    def set_path_joint_constraint(
        self,
        joint_positions: Sequence[float],
        joint_names: Sequence[str] | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> None:
        """Hold joints to positions along the path."""
        self._goal.request.path_constraints.joint_constraints.extend(
            self.create_joint_constraints(joint_positions, joint_names, tolerance, weight)
        )

    def set_path_position_constraint(
        self,
        position: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> None:
        """Hold a link to a sphere along the path."""
        self._goal.request.path_constraints.position_constraints.append(
            self.create_position_constraint(position, frame_id, target_link, tolerance, weight)
        )

    def set_path_orientation_constraint(
        self,
        quat_xyzw: Any,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance: Any = 0.001,
        weight: float = 1.0,
        parameterization: int = 0,
    ) -> None:
        """Hold a link to an orientation along the path."""
        self._goal.request.path_constraints.orientation_constraints.append(
            self.create_orientation_constraint(
                quat_xyzw, frame_id, target_link, tolerance, weight, parameterization
            )
        )

    def clear_path_constraints(self) -> None:
        """Forget the path's constraints."""
        self._goal.request.path_constraints = Constraints()

    def set_workspace_parameters(
        self,
        min_corner: Sequence[float],
        max_corner: Sequence[float],
        frame_id: str | None = None,
    ) -> None:
        """Set the box that sampling of floating joints is limited to."""
        workspace = self._goal.request.workspace_parameters
        workspace.header.frame_id = self._base_link if frame_id is None else frame_id
        workspace.header.stamp = self._node.get_clock().now().to_msg()
        for corner, values in (
            (workspace.min_corner, min_corner),
            (workspace.max_corner, max_corner),
        ):
            corner.x, corner.y, corner.z = (float(value) for value in values)
