"""Goals as moveit_msgs/Constraints state them, read for the planner."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tracerisk.errors import RobotError
from tracerisk.ros.moveit.move_group import GoalKind, MoveGroupServer, Plan, PoseGoal
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.trajectory_execution import ErrorCode
from tracerisk.ros.transforms.poses import compose, unit_quaternion
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import Scaling

_AT_ORIGIN = (0.0, 0.0, 0.0)


class RequestError(Exception):
    """A request that move_group answers with an error code: `code`."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code


class GoalReader:
    """Reads goals by what a server knows of groups, links and frames."""

    def __init__(self, server: MoveGroupServer) -> None:
        self._server = server

    def plan(
        self,
        group: str,
        alternatives: Sequence[Any],
        scaling: Scaling,
        start: Mapping[str, float] | None,
    ) -> Plan:
        """Plan to the first of several Constraints that can be met.

        Raises:
            RequestError: there is none, or one names an unknown frame or no region.
        """
        target, poses = self.goals(group, alternatives)
        if target is not None:
            return self._server.plan_joints(group, target, scaling, start)
        return self._server.plan_pose(group, poses, scaling, start)

    def goals(
        self, group: str, alternatives: Sequence[Any]
    ) -> tuple[dict[str, float] | None, list[list[PoseGoal]]]:
        """Return the joint target of alternatives, where one has any, else their pose goals.

        Raises:
            RequestError: as `plan`.
        """
        poses = []
        for constraints in alternatives:
            if constraints.joint_constraints:
                joints = constraints.joint_constraints
                return {one.joint_name: float(one.position) for one in joints}, []
            poses.append(self.pose_goals(group, constraints))
        if not poses:
            raise RequestError(ErrorCode.INVALID_GOAL_CONSTRAINTS, "the request has no goal")
        return None, poses

    def pose_goals(self, group: str, constraints: Any) -> list[PoseGoal]:
        """Return the goal of each link that position and orientation constraints speak of.

        Raises:
            RequestError: as `plan`.
        """
        places: dict[str, Pose] = {}
        kinds: dict[str, GoalKind] = {}
        nearness: dict[str, float] = {}
        turns: dict[str, float] = {}
        for one in constraints.position_constraints:
            link = one.link_name or self.tip(group)
            region = one.constraint_region
            if not region.primitive_poses:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"the position constraint of link '{link}' has no primitive as its region",
                )
            places[link] = compose(
                self.frame(one.header.frame_id), message_pose(region.primitive_poses[0])
            )
            kinds[link] = "position"
            sizes = list(region.primitives[0].dimensions) if region.primitives else []
            nearness[link] = max(min(sizes, default=0.0) / 2, 1e-4)
        for one in constraints.orientation_constraints:
            link = one.link_name or self.tip(group)
            q = one.orientation
            turn = Pose(_AT_ORIGIN, unit_quaternion((q.x, q.y, q.z, q.w)))
            wanted = compose(self.frame(one.header.frame_id), turn).orientation
            known = places.get(link)
            kinds[link] = "orientation" if known is None else "pose"
            places[link] = Pose(_AT_ORIGIN if known is None else known.position, wanted)
            turns[link] = max(one.absolute_x_axis_tolerance, 1e-3)
        return [
            PoseGoal(link, pose, kinds[link], nearness.get(link, 1e-4), turns.get(link, 1e-3))
            for link, pose in places.items()
        ]

    def check_group(self, name: str) -> None:
        """Raise RequestError where the robot has no such group."""
        try:
            self._server.group(name)
        except RobotError as error:
            raise RequestError(ErrorCode.INVALID_GROUP_NAME, error.message) from error

    def tip(self, group: str) -> str:
        """Return the group's tip link; raise RequestError where it has none."""
        link = self._server.end_effector_link(group)
        if not link:
            raise RequestError(ErrorCode.INVALID_LINK_NAME, f"group '{group}' has no tip link")
        return link

    def frame(self, name: str) -> Pose:
        """Return the pose of a frame; raise RequestError for an unknown one."""
        pose = self._server.frame(name)
        if pose is None:
            raise RequestError(ErrorCode.FRAME_TRANSFORM_FAILURE, f"unknown frame '{name}'")
        return pose
