"""move_group on the graph: its actions and services, for programs that talk to it themselves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import RobotError
from tracerisk.ros.action_graph import ActionGoal
from tracerisk.ros.message_dialect import set_time
from tracerisk.ros.move_group import GoalKind, MoveGroupServer, Plan, PoseGoal, Scaling
from tracerisk.ros.path_constraints import message_pose, violation
from tracerisk.ros.poses import compose, inverse
from tracerisk.ros.trajectory_execution import ErrorCode, Execution
from tracerisk.ros.twin_messages import TwinMessages
from tracerisk.ros.twin_trajectory_messages import TrajectoryRefusedError, twin_trajectory
from tracerisk.ros.virtual_clock import EPOCH_NS
from tracerisk.twin.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

MOVE_GROUP = "moveit_msgs/MoveGroup"
EXECUTE_TRAJECTORY = "moveit_msgs/ExecuteTrajectory"
_NODE = "/move_group"


class RequestError(Exception):
    """A request that move_group answers with an error code: `code`."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code


class MoveItInterfaces:
    """Plans, executes and answers on the graph with the server that every client shares."""

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._runtime = runtime
        self._server = runtime.client(MoveGroupServer)
        self._messages = messages
        for name, kind, handle in (
            ("compute_ik", "GetPositionIK", self._position_ik),
            ("compute_fk", "GetPositionFK", self._position_fk),
            ("compute_cartesian_path", "GetCartesianPath", self._cartesian_path),
            ("plan_kinematic_path", "GetMotionPlan", self._motion_plan),
        ):
            runtime.graph.offer(name, f"moveit_msgs/{kind}", handle, node=_NODE)

    # Actions

    def move_group(self, goal: ActionGoal) -> None:
        """Plan, and execute unless the goal asks for a plan alone."""
        goal.accept()
        asked = goal.message
        plan = self._planned(asked.request)
        result = self._messages.part(MOVE_GROUP, "Result")
        result.trajectory_start = self._state(self._server.positions())
        if plan.trajectory is None:
            self._finish(goal, result, plan.code, plan.message)
            return
        result.planned_trajectory = self._trajectory(plan.trajectory)
        if asked.planning_options.plan_only:
            self._finish(goal, result, ErrorCode.SUCCESS)
            return
        result.executed_trajectory = self._trajectory(plan.trajectory)
        self._execute(goal, plan.trajectory, result)

    def execute_trajectory(self, goal: ActionGoal) -> None:
        """Execute the goal's trajectory."""
        goal.accept()
        result = self._messages.part(EXECUTE_TRAJECTORY, "Result")
        message = goal.message.trajectory.joint_trajectory
        # Its stamp is that of the plan, not of the motion's beginning.
        set_time(message.header.stamp, 0)
        scheduler = self._runtime.scheduler
        try:
            trajectory = twin_trajectory(message, self._runtime.twin, scheduler.now_ns)
        except TrajectoryRefusedError as error:
            self._server.execution.tell("execution_failure", f"a trajectory is none: {error}")
            self._finish(goal, result, ErrorCode.INVALID_MOTION_PLAN, str(error))
            return
        self._execute(goal, trajectory, result)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Stop what the goal moves; it ends with its motion."""
        goal.accept_cancel()
        execution = goal.data
        if isinstance(execution, Execution) and execution.motion.outcome == "active":
            self._runtime.twin.stop(execution.motion.joints)

    def _execute(self, goal: ActionGoal, trajectory: JointTrajectory, result: Any) -> None:
        execution = self._server.execution.start(trajectory)
        if isinstance(execution, ErrorCode):
            self._finish(goal, result, execution, "the trajectory was not executed")
            return
        goal.data = execution
        self._runtime.scheduler.spawn(
            lambda: self._finish(goal, result, self._server.execution.wait(execution)),
            f"goal of {goal.client.name}",
            inherit=False,
            is_controllers=False,
        )

    def _finish(self, goal: ActionGoal, result: Any, code: ErrorCode, message: str = "") -> None:
        result.error_code.val = int(code)
        if code is ErrorCode.SUCCESS:
            goal.succeed(result, message)
        elif code is ErrorCode.PREEMPTED:
            goal.cancel(result, message)
        else:
            goal.abort(result, message)

    # Services

    def _position_ik(self, request: Any) -> Any:
        asked, answer = request.ik_request, self._messages.response("moveit_msgs/GetPositionIK")
        try:
            self._check_group(asked.group_name)
            link = asked.ik_link_name or self._tip(asked.group_name)
            base = self._frame(asked.pose_stamped.header.frame_id)
            goal = PoseGoal(link, compose(base, message_pose(asked.pose_stamped.pose)))
            found = self._server.reach(
                asked.group_name, [goal], self._start(asked.robot_state) or None
            )
        except RequestError as error:
            answer.error_code.val = int(error.code)
        except PlanningError:
            answer.error_code.val = int(ErrorCode.NO_IK_SOLUTION)
        else:
            answer.solution = self._state({**self._server.positions(), **found})
            answer.error_code.val = int(ErrorCode.SUCCESS)
        return answer

    def _position_fk(self, request: Any) -> Any:
        answer = self._messages.response("moveit_msgs/GetPositionFK")
        try:
            back = inverse(self._frame(request.header.frame_id))
            start = self._start(request.robot_state)
            poses = [self._server.forward(start, link) for link in request.fk_link_names]
        except RequestError as error:
            answer.error_code.val = int(error.code)
            return answer
        except RobotError:
            answer.error_code.val = int(ErrorCode.INVALID_LINK_NAME)
            return answer
        stamped = []
        for pose in poses:
            message = self._messages.new("geometry_msgs/PoseStamped")
            message.header.frame_id = request.header.frame_id or self._server.planning_frame
            self._messages.stamp(message.header, self._runtime.scheduler.now_ns)
            _set_pose(message.pose, compose(back, pose))
            stamped.append(message)
        answer.pose_stamped = stamped
        answer.fk_link_names = list(request.fk_link_names)
        answer.error_code.val = int(ErrorCode.SUCCESS)
        return answer

    def _cartesian_path(self, request: Any) -> Any:
        answer = self._messages.response("moveit_msgs/GetCartesianPath")
        answer.start_state = self._state(self._server.positions())
        try:
            self._check_group(request.group_name)
            base = self._frame(request.header.frame_id)
            if request.max_step <= 0.0:
                raise RequestError(ErrorCode.FAILURE, "max_step must be more than 0")
            plan, fraction = self._server.plan_cartesian(
                request.group_name,
                [compose(base, message_pose(pose)) for pose in request.waypoints],
                link=request.link_name or self._tip(request.group_name),
                eef_step=request.max_step,
                start=self._start(request.start_state) or None,
            )
        except RequestError as error:
            answer.error_code.val = int(error.code)
            return answer
        answer.fraction = fraction
        answer.error_code.val = int(plan.code)
        if plan.trajectory is not None:
            answer.solution = self._trajectory(plan.trajectory)
        return answer

    def _motion_plan(self, request: Any) -> Any:
        answer = self._messages.response("moveit_msgs/GetMotionPlan")
        response = answer.motion_plan_response
        plan = self._planned(request.motion_plan_request)
        response.group_name = request.motion_plan_request.group_name
        response.trajectory_start = self._state(self._server.positions())
        response.error_code.val = int(plan.code)
        if plan.trajectory is not None:
            response.trajectory = self._trajectory(plan.trajectory)
        return answer

    # Planning

    def _planned(self, request: Any) -> Plan:
        try:
            self._check_group(request.group_name)
            start = self._start(request.start_state) or None
            if start is not None:
                start = {**self._server.positions(), **start}
            scaling = Scaling(
                _fraction(request.max_velocity_scaling_factor),
                _fraction(request.max_acceleration_scaling_factor),
            )
            plan = self._to_goals(request, scaling, start)
        except RequestError as error:
            self._server.execution.tell("planning_failure", f"planning failed: {error}")
            return Plan(error.code, None, str(error))
        if plan.trajectory is None:
            return plan
        broken = violation(
            request.path_constraints, plan.trajectory, self._server.forward, self._server.frame
        )
        if broken is not None:
            told = f"planning for group '{request.group_name}' failed: {broken}"
            self._server.execution.tell("planning_failure", told)
            return Plan(ErrorCode.PLANNING_FAILED, None, broken)
        return plan

    def _to_goals(self, request: Any, scaling: Scaling, start: Mapping[str, float] | None) -> Plan:
        group = request.group_name
        poses = []
        for constraints in request.goal_constraints:
            if constraints.joint_constraints:
                target = {one.joint_name: one.position for one in constraints.joint_constraints}
                return self._server.plan_joints(group, target, scaling, start)
            poses.append(self._pose_goals(group, constraints))
        if not poses:
            raise RequestError(ErrorCode.INVALID_GOAL_CONSTRAINTS, "the request has no goal")
        return self._server.plan_pose(group, poses, scaling, start)

    def _pose_goals(self, group: str, constraints: Any) -> list[PoseGoal]:
        """Return the goal of each link that position and orientation constraints speak of."""
        places: dict[str, Pose] = {}
        kinds: dict[str, GoalKind] = {}
        nearness: dict[str, float] = {}
        turns: dict[str, float] = {}
        for one in constraints.position_constraints:
            link = one.link_name or self._tip(group)
            region = one.constraint_region
            if not region.primitive_poses:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"the position constraint of link '{link}' has no primitive as its region",
                )
            places[link] = compose(
                self._frame(one.header.frame_id), message_pose(region.primitive_poses[0])
            )
            kinds[link] = "position"
            sizes = list(region.primitives[0].dimensions) if region.primitives else []
            nearness[link] = max(min(sizes, default=0.0) / 2, 1e-4)
        for one in constraints.orientation_constraints:
            link = one.link_name or self._tip(group)
            q = one.orientation
            zero = self._messages.new("geometry_msgs/Pose")
            zero.orientation = q
            wanted = compose(self._frame(one.header.frame_id), message_pose(zero)).orientation
            known = places.get(link)
            kinds[link] = "orientation" if known is None else "pose"
            places[link] = Pose((0.0, 0.0, 0.0) if known is None else known.position, wanted)
            turns[link] = max(one.absolute_x_axis_tolerance, 1e-3)
        return [
            PoseGoal(link, pose, kinds[link], nearness.get(link, 1e-4), turns.get(link, 1e-3))
            for link, pose in places.items()
        ]

    def _check_group(self, name: str) -> None:
        try:
            self._server.group(name)
        except RobotError as error:
            raise RequestError(ErrorCode.INVALID_GROUP_NAME, error.message) from error

    def _tip(self, group: str) -> str:
        link = self._server.end_effector_link(group)
        if not link:
            raise RequestError(ErrorCode.INVALID_LINK_NAME, f"group '{group}' has no tip link")
        return link

    def _frame(self, name: str) -> Pose:
        pose = self._server.frame(name)
        if pose is None:
            raise RequestError(ErrorCode.FRAME_TRANSFORM_FAILURE, f"unknown frame '{name}'")
        return pose

    def _start(self, state: Any) -> dict[str, float]:
        known = {joint.name for joint in self._server.robot.joints}
        given = dict(zip(state.joint_state.name, state.joint_state.position, strict=False))
        return {name: float(value) for name, value in given.items() if name in known}

    # Messages

    def _state(self, positions: Mapping[str, float]) -> Any:
        state = self._messages.new("moveit_msgs/RobotState")
        state.joint_state.header.frame_id = self._server.planning_frame
        set_time(state.joint_state.header.stamp, EPOCH_NS + self._runtime.scheduler.now_ns)
        state.joint_state.name = list(positions)
        state.joint_state.position = [float(value) for value in positions.values()]
        return state

    def _trajectory(self, trajectory: JointTrajectory) -> Any:
        message = self._messages.new("moveit_msgs/RobotTrajectory")
        joint_trajectory = message.joint_trajectory
        joint_trajectory.header.frame_id = self._server.planning_frame
        joint_trajectory.joint_names = list(trajectory.joints)
        acceleration = np.zeros_like(trajectory.velocity)
        if len(trajectory.time) > 1:
            acceleration = np.gradient(trajectory.velocity, trajectory.time, axis=0)
        points = []
        for time, position, velocity, change in zip(
            trajectory.time, trajectory.position, trajectory.velocity, acceleration, strict=True
        ):
            point = self._messages.new("trajectory_msgs/JointTrajectoryPoint")
            point.positions, point.velocities = position.tolist(), velocity.tolist()
            point.accelerations = change.tolist()
            set_time(point.time_from_start, round(float(time) * 1e9))
            points.append(point)
        joint_trajectory.points = points
        return message


def _fraction(value: float) -> float:
    """Return a scaling factor as MoveIt takes it: what is not within (0, 1] is 1."""
    return float(value) if 0.0 < value <= 1.0 else 1.0


def _set_pose(message: Any, pose: Pose) -> None:
    p, q = message.position, message.orientation
    p.x, p.y, p.z = pose.position
    q.x, q.y, q.z, q.w = pose.orientation
