"""move_group on the graph: its actions and services, for programs that talk to it themselves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tracerisk.errors import RobotError
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.graph.topic_ends import Publication
from tracerisk.ros.messages.dialect import nanoseconds, set_time
from tracerisk.ros.moveit.actions.goal_turns import GoalTurns
from tracerisk.ros.moveit.goal_constraints import GoalReader, RequestError
from tracerisk.ros.moveit.messages import (
    set_pose,
    state_message,
    trajectory_message,
)
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.path_constraints import message_pose
from tracerisk.ros.moveit.plan_records import RATED, Plan, PoseGoal, valid_fraction
from tracerisk.ros.moveit.scene.interfaces import SceneInterfaces
from tracerisk.ros.moveit.trajectory_execution import NOTHING, Asker, ErrorCode, Execution
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.trajectory_messages import TrajectoryRefusedError, twin_trajectory
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.ros.transforms.poses import compose, inverse
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError
from tracerisk.twin.robots.robot_parts import Scaling

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

MOVE_GROUP = "moveit_msgs/MoveGroup"
EXECUTE_TRAJECTORY = "moveit_msgs/ExecuteTrajectory"
_ASKERS: Mapping[str, Asker] = {
    MOVE_GROUP: "move_action",
    EXECUTE_TRAJECTORY: "execute_trajectory",
}
EXECUTION_EVENTS = "/trajectory_execution_event"
"""The topic on which MoveIt takes `stop` for all that it executes."""


class MoveItInterfaces(TwinNode):
    """Plans, executes and answers on the graph with the server that every client shares."""

    node = "/move_group"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._server = runtime.client(MoveGroupServer)
        self._read_poses = runtime.client(ReadPoses)
        self._goals = GoalReader(self._server, self._read_poses)
        self._turns = {
            MOVE_GROUP: GoalTurns(runtime, "move-action", self._move_group, self._stop),
            EXECUTE_TRAJECTORY: GoalTurns(
                runtime, "execute-trajectory", self._execute_trajectory, self._stop
            ),
        }
        self._hear(EXECUTION_EVENTS, "std_msgs/String", self._on_event)
        for name, kind, handle in (
            ("compute_ik", "GetPositionIK", self._position_ik),
            ("compute_fk", "GetPositionFK", self._position_fk),
            ("compute_cartesian_path", "GetCartesianPath", self._cartesian_path),
            ("plan_kinematic_path", "GetMotionPlan", self._motion_plan),
            ("check_state_validity", "GetStateValidity", self._state_validity),
        ):
            self._offer(name, f"moveit_msgs/{kind}", handle)
        # As a move_group whose map is empty, for no camera fills it.
        self._offer("clear_octomap", "std_srvs/Empty", lambda *_: None)
        SceneInterfaces(runtime, messages)

    # Actions

    def on_goal(self, goal: ActionGoal) -> None:
        """Take a goal of either action."""
        self._turns[goal.client.type_name].take(goal)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Take a request to cancel a goal of either action."""
        self._turns[goal.client.type_name].cancel(goal)

    def _move_group(self, goal: ActionGoal) -> None:
        """Plan, and execute unless the goal asks for a plan alone."""
        goal.accept()
        planning_ns = self._graph.carrier.planning_ns()
        if planning_ns:
            due_ns = self._scheduler.now_ns + planning_ns
            self._graph.carrier.at(due_ns, lambda: self._plan_and_execute(goal))
        else:
            self._plan_and_execute(goal)

    def _plan_and_execute(self, goal: ActionGoal) -> None:
        asked = goal.message
        if goal.state is not GoalState.ACTIVE:
            self._finish(goal, self._messages.part(MOVE_GROUP, "Result"), ErrorCode.PREEMPTED)
            return
        plan = self._planned(asked.request)
        result = self._messages.part(MOVE_GROUP, "Result")
        result.trajectory_start = self._state(self._server.positions())
        if plan.trajectory is None:
            if not asked.planning_options.plan_only:
                self._commands.refuse("move_group", goal.stack)
            self._give_way(goal)
            self._finish(goal, result, plan.code, plan.message)
            return
        result.planned_trajectory = self._trajectory(plan.trajectory)
        if asked.planning_options.plan_only:
            self._give_way(goal)
            self._finish(goal, result, ErrorCode.SUCCESS)
            return
        result.executed_trajectory = self._trajectory(plan.trajectory)
        self._execute(goal, plan.trajectory, result)

    def _execute_trajectory(self, goal: ActionGoal) -> None:
        """Execute the goal's trajectory."""
        goal.accept()
        result = self._messages.part(EXECUTE_TRAJECTORY, "Result")
        message = goal.message.trajectory.joint_trajectory
        # Its stamp is that of the plan, not of the motion's beginning.
        set_time(message.header.stamp, 0)
        scheduler = self._scheduler
        try:
            trajectory, first = NOTHING, {}
            if message.points:
                trajectory = twin_trajectory(message, self._twin, scheduler.now_ns)
                given = list(map(float, message.points[0].positions))
                first = dict(zip(message.joint_names, given, strict=True))
                if not nanoseconds(message.points[-1].time_from_start):
                    at_once = np.zeros(1)
                    trajectory = JointTrajectory(
                        tuple(first), at_once, np.array([given]), np.zeros((1, len(given)))
                    )
        except TrajectoryRefusedError as error:
            self._server.execution.report("execution_failure", f"a trajectory is none: {error}")
            self._commands.refuse("move_group", goal.stack)
            self._give_way(goal)
            self._finish(goal, result, ErrorCode.CONTROL_FAILED, str(error))
            return
        self._execute(goal, trajectory, result, first)

    def _stop(self, goal: ActionGoal) -> None:
        """Stop what a goal moves; it ends with its motion."""
        execution = goal.data
        if isinstance(execution, Execution) and execution.motion.outcome == "active":
            self._twin.stop(execution.motion.joints)

    def _on_event(self, message: Any, publication: Publication) -> None:
        """Stop what is being executed, whoever asked for it."""
        del publication
        if message.data == "stop":
            self._server.execution.stop()

    def _give_way(self, goal: ActionGoal) -> None:
        """End the goal before where a new one does so, for this one moves nothing."""
        if self._turns[goal.client.type_name].preempts:
            self._server.execution.give_way(_ASKERS[goal.client.type_name])

    def _execute(
        self,
        goal: ActionGoal,
        trajectory: JointTrajectory,
        result: Any,
        first: Mapping[str, float] | None = None,
    ) -> None:
        type_name = goal.client.type_name
        execution = self._server.execution.start(
            trajectory,
            by=_ASKERS[type_name],
            preempts=self._turns[type_name].preempts,
            goal=goal,
            first=first,
        )
        if isinstance(execution, ErrorCode):
            self._finish(goal, result, execution, "nothing was executed")
            return
        goal.data = execution
        self._scheduler.spawn(
            lambda: self._finish(goal, result, self._server.execution.wait(execution)),
            f"goal of {goal.client.name}",
            inherit=False,
            is_controllers=False,
        )

    def _finish(self, goal: ActionGoal, result: Any, code: ErrorCode, message: str = "") -> None:
        result.error_code.val = int(code)
        # MoveIt 2 aborts a goal of execute_trajectory that was stopped.
        may_be_cancelled = goal.client.type_name == MOVE_GROUP or not self._messages.is_ros2
        if code is ErrorCode.SUCCESS:
            goal.succeed(result, message)
        elif code is ErrorCode.PREEMPTED and may_be_cancelled:
            goal.cancel(result, message)
        else:
            goal.abort(result, message)
        self._turns[goal.client.type_name].over(goal)

    # Services

    def _position_ik(self, request: Any, answer: Any) -> None:
        asked = request.ik_request
        wanted = message_pose(asked.pose_stamped.pose).position
        try:
            self._goals.check_group(asked.group_name)
            link = asked.ik_link_name or self._goals.tip(asked.group_name)
            base = self._goals.frame(asked.pose_stamped.header.frame_id)
            given = message_pose(asked.pose_stamped.pose)
            self._goals.given(asked.pose_stamped.header.frame_id, given, link)
            goal = PoseGoal(link, compose(base, given))
            reach = self._server.reach(
                asked.group_name, [goal], self._start(asked.robot_state) or None
            )
        except (RequestError, PlanningError) as error:
            code = error.code if isinstance(error, RequestError) else ErrorCode.NO_IK_SOLUTION
            answer.error_code.val = int(code)
            self._server.execution.report(
                "ik_failure",
                f"inverse kinematics of group '{asked.group_name}' failed ({code.name}, {code}): "
                f"{error}",
                object_name=asked.group_name,
                target=wanted,
            )
        else:
            self._server.execution.succeeded("ik_failure", asked.group_name, wanted)
            answer.solution = self._state({**self._server.positions(), **reach})
            answer.error_code.val = int(ErrorCode.SUCCESS)

    def _position_fk(self, request: Any, answer: Any) -> None:
        links = ", ".join(request.fk_link_names)
        try:
            back = inverse(self._goals.frame(request.header.frame_id))
            start = self._start(request.robot_state)
            poses = [self._server.forward(start, link) for link in request.fk_link_names]
        except (RequestError, RobotError) as error:
            code = error.code if isinstance(error, RequestError) else ErrorCode.INVALID_LINK_NAME
            answer.error_code.val = int(code)
            self._server.execution.report(
                "fk_failure",
                f"forward kinematics failed ({code.name}, {code}): {error}",
                object_name=links,
            )
            return
        self._server.execution.succeeded("fk_failure", links, ())
        stamped = []
        for link, pose in zip(request.fk_link_names, poses, strict=True):
            message = self._messages.new("geometry_msgs/PoseStamped")
            message.header.frame_id = request.header.frame_id or self._server.planning_frame
            self._now(message.header)
            seen = compose(back, pose)
            self._read_poses.read(message.header.frame_id, seen, link, "compute_fk")
            set_pose(message.pose, seen)
            stamped.append(message)
        answer.pose_stamped = stamped
        answer.fk_link_names = list(request.fk_link_names)
        answer.error_code.val = int(ErrorCode.SUCCESS)

    def _cartesian_path(self, request: Any, answer: Any) -> None:
        answer.start_state = self._state(self._server.positions())
        try:
            self._goals.check_group(request.group_name)
            base = self._goals.frame(request.header.frame_id)
            link = request.link_name or self._goals.tip(request.group_name)
            for pose in request.waypoints:
                self._goals.given(request.header.frame_id, message_pose(pose), link)
            if request.max_step <= 0.0:
                raise RequestError(ErrorCode.FAILURE, "max_step must be more than 0")
            # Its message has them since Jazzy: moveit/moveit_msgs srv/GetCartesianPath.srv.
            is_scaled = hasattr(request, "max_velocity_scaling_factor")
            with self._server.planning_under(request.path_constraints):
                plan, fraction = self._server.plan_cartesian(
                    request.group_name,
                    [compose(base, message_pose(pose)) for pose in request.waypoints],
                    link=link,
                    eef_step=request.max_step,
                    start=self._start(request.start_state) or None,
                    scaling=_scaling(request) if is_scaled else RATED,
                )
        except RequestError as error:
            answer.error_code.val = int(error.code)
            self._server.execution.report(
                "planning_failure",
                f"a Cartesian path failed: {error}",
                object_name=request.group_name,
            )
            return
        answer.fraction = fraction
        answer.error_code.val = int(plan.code)
        if plan.trajectory is not None:
            answer.solution = self._trajectory(plan.trajectory)

    def _state_validity(self, request: Any, answer: Any) -> None:
        """Answer whether a state collides, with the names of each pair that does."""
        pairs = self._twin.collisions(self._start(request.robot_state))
        answer.valid = not pairs
        contacts = []
        for one, other in pairs:
            contact = self._messages.new("moveit_msgs/ContactInformation")
            contact.header.frame_id = self._server.planning_frame
            self._now(contact.header)
            contact.contact_body_1, contact.contact_body_2 = one, other
            contacts.append(contact)
        answer.contacts = contacts

    def _motion_plan(self, request: Any, answer: Any) -> None:
        response = answer.motion_plan_response
        plan = self._planned(request.motion_plan_request)
        response.group_name = request.motion_plan_request.group_name
        response.trajectory_start = self._state(self._server.positions())
        response.error_code.val = int(plan.code)
        if plan.trajectory is not None:
            response.trajectory = self._trajectory(plan.trajectory)

    # Planning

    def _planned(self, request: Any) -> Plan:
        try:
            self._goals.check_group(request.group_name)
            start = self._start(request.start_state) or None
            if start is not None:
                start = {**self._server.positions(), **start}
            with self._server.planning_under(request.path_constraints):
                return self._goals.plan(
                    request.group_name, request.goal_constraints, _scaling(request), start
                )
        except RequestError as error:
            self._server.execution.report(
                "planning_failure", f"planning failed: {error}", object_name=request.group_name
            )
            return Plan(error.code, None, str(error))

    def _start(self, state: Any) -> dict[str, float]:
        known = {joint.name for joint in self._server.robot.joints}
        given = dict(zip(state.joint_state.name, state.joint_state.position, strict=False))
        return {name: float(value) for name, value in given.items() if name in known}

    # Messages

    def _state(self, positions: Mapping[str, float]) -> Any:
        frame, now_ns = self._server.planning_frame, self._scheduler.now_ns
        return state_message(self._messages.new, positions, frame, now_ns)

    def _trajectory(self, trajectory: JointTrajectory) -> Any:
        return trajectory_message(self._messages.new, trajectory, self._server.planning_frame)


def _scaling(request: Any) -> Scaling:
    """Return the fractions of the rated speeds and accelerations that a request wants."""
    return Scaling(
        valid_fraction(request.max_velocity_scaling_factor),
        valid_fraction(request.max_acceleration_scaling_factor),
    )
