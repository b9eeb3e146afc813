"""Plans and executes motions by the actions and services of MoveIt 2."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from enum import Enum
from operator import attrgetter
from typing import Any

from action_msgs.msg import GoalStatus
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import MoveItErrorCodes
from moveit_msgs.srv import GetCartesianPath, GetMotionPlan
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from ._kinematics import KinematicsServices
from ._messages import (
    init_dummy_joint_trajectory_from_state,
    init_execute_trajectory_goal,
    init_joint_state,
)
from ._scene import Scene
from ._waiting import wait_until
from .utils import enum_to_str

__all__ = [
    "MoveIt2",
    "MoveIt2State",
    "init_dummy_joint_trajectory_from_state",
    "init_execute_trajectory_goal",
    "init_joint_state",
]


class MoveIt2State(Enum):
    """What goes on."""

    IDLE = 0
    REQUESTING = 1
    EXECUTING = 2


def _of(path: str, doc: str) -> Any:
    """Return a property: a field of one of the messages that are kept for requests."""
    message, _, field = path.rpartition(".")

    def write(kept: MoveIt2, value: Any) -> None:
        setattr(attrgetter(message)(kept), field, value)

    return property(attrgetter(path), write, doc=doc)


class MoveIt2(KinematicsServices, Scene):
    """Plans and executes motions of one group; `node` is to be spun by somebody."""

    max_velocity = _of("_goal.request.max_velocity_scaling_factor", "Fraction of the rated speed.")
    max_acceleration = _of(
        "_goal.request.max_acceleration_scaling_factor", "Fraction of the rated acceleration."
    )
    num_planning_attempts = _of("_goal.request.num_planning_attempts", "How often is planned.")
    allowed_planning_time = _of("_goal.request.allowed_planning_time", "How long is planned [s].")
    pipeline_id = _of("_goal.request.pipeline_id", "The planning pipeline.")
    planner_id = _of("_goal.request.planner_id", "The planner.")
    cartesian_avoid_collisions = _of(
        "_cartesian_request.avoid_collisions", "Whether lines avoid bodies."
    )
    cartesian_jump_threshold = _of("_cartesian_request.jump_threshold", "The largest jump.")
    cartesian_prismatic_jump_threshold = _of(
        "_cartesian_request.prismatic_jump_threshold", "The largest jump of a prismatic joint [m]."
    )
    cartesian_revolute_jump_threshold = _of(
        "_cartesian_request.revolute_jump_threshold", "The largest jump of a revolute joint [rad]."
    )

    def __init__(
        self,
        node: Any,
        joint_names: Sequence[str],
        base_link_name: str,
        end_effector_name: str,
        group_name: str = "arm",
        execute_via_moveit: bool = False,
        ignore_new_calls_while_executing: bool = False,
        callback_group: Any = None,
        follow_joint_trajectory_action_name: str = "DEPRECATED",
        use_move_group_action: bool = False,
    ) -> None:
        self._node = node
        self._callback_group = callback_group
        if execute_via_moveit:
            self._warn("Parameter `execute_via_moveit` is deprecated; use `use_move_group_action`.")
        if follow_joint_trajectory_action_name != "DEPRECATED":
            self._warn("Parameter `follow_joint_trajectory_action_name` is deprecated.")
        self._uses_move_group = use_move_group_action or execute_via_moveit
        self._ignores_calls = ignore_new_calls_while_executing
        self._begin_goals(joint_names, base_link_name, end_effector_name, group_name)
        self._begin_scene()
        self._stop_publisher = node.create_publisher(String, "/trajectory_execution_event", 1)
        self._mutex = threading.Lock()
        self._state: Any = None
        self._has_new_state = False
        self._is_requested = self._is_executing = False
        self.motion_suceeded = False
        self._handle: Any = None
        self._error_code: Any = None
        self._cartesian_request = GetCartesianPath.Request()
        self._cartesian_request.avoid_collisions = True
        node.create_subscription(
            JointState, "joint_states", self._take_state, 1, callback_group=callback_group
        )
        self._move_action_client = ActionClient(
            node, MoveGroup, "move_action", callback_group=callback_group
        )
        self._execute_trajectory_action_client = ActionClient(
            node, ExecuteTrajectory, "execute_trajectory", callback_group=callback_group
        )
        self._plan_kinematic_path_service = self._client(GetMotionPlan, "plan_kinematic_path")
        self._plan_cartesian_path_service = self._client(GetCartesianPath, "compute_cartesian_path")
        self._begin_kinematics()

    # What goes on

    def query_state(self) -> MoveIt2State:
        """Return what goes on."""
        if self._is_requested:
            return MoveIt2State.REQUESTING
        return MoveIt2State.EXECUTING if self._is_executing else MoveIt2State.IDLE

    def cancel_execution(self) -> None:
        """Stop what is being executed."""
        if self.query_state() != MoveIt2State.EXECUTING:
            self._warn("Attempted to cancel without active goal.")
            return
        self._stop_publisher.publish(String(data="stop"))

    def get_execution_future(self) -> Any:
        """Return the future of the result, None while nothing is executed."""
        if self.query_state() != MoveIt2State.EXECUTING:
            self._warn("Need active goal for future.")
            return None
        return self._handle.get_result_async()

    def get_last_execution_error_code(self) -> Any:
        """Return the MoveItErrorCodes of the last execution, None before the first."""
        return self._error_code

    # Moves

    def move_to_pose(
        self,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        target_link: str | None = None,
        frame_id: str | None = None,
        tolerance_position: float = 0.001,
        tolerance_orientation: Any = 0.001,
        weight_position: float = 1.0,
        cartesian: bool = False,
        weight_orientation: float = 1.0,
        cartesian_max_step: float = 0.0025,
        cartesian_fraction_threshold: float = 0.0,
    ) -> None:
        """Plan to a pose and begin to execute; `wait_until_executed` waits for the end."""
        goal: dict[str, Any] = {
            "pose": self._stamped(pose, position, quat_xyzw, frame_id),
            "target_link": target_link,
            "tolerance_position": tolerance_position,
            "tolerance_orientation": tolerance_orientation,
            "weight_position": weight_position,
            "weight_orientation": weight_orientation,
        }
        if self._uses_move_group and not cartesian:
            if self._is_skipped():
                return
            self.set_pose_goal(**goal)
            self._send_move()
            return
        self.execute(
            self.plan(
                **goal,
                cartesian=cartesian,
                max_step=cartesian_max_step,
                cartesian_fraction_threshold=cartesian_fraction_threshold,
            )
        )

    def move_to_configuration(
        self,
        joint_positions: Sequence[float],
        joint_names: Sequence[str] | None = None,
        tolerance: float = 0.001,
        weight: float = 1.0,
    ) -> None:
        """Plan to joint positions and begin to execute."""
        if self._uses_move_group:
            if self._is_skipped():
                return
            self.set_joint_goal(joint_positions, joint_names, tolerance, weight)
            self._send_move()
            return
        self.execute(
            self.plan(
                joint_positions=joint_positions,
                joint_names=joint_names,
                tolerance_joint_position=tolerance,
                weight_joint_position=weight,
            )
        )

    def plan(
        self,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        joint_positions: Sequence[float] | None = None,
        joint_names: Sequence[str] | None = None,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance_position: float = 0.001,
        tolerance_orientation: Any = 0.001,
        tolerance_joint_position: float = 0.001,
        weight_position: float = 1.0,
        weight_orientation: float = 1.0,
        weight_joint_position: float = 1.0,
        start_joint_state: Any = None,
        cartesian: bool = False,
        max_step: float = 0.0025,
        cartesian_fraction_threshold: float = 0.0,
    ) -> Any:
        """Return the trajectory to the goal, None where there is none."""
        future = self.plan_async(
            pose,
            position,
            quat_xyzw,
            joint_positions,
            joint_names,
            frame_id,
            target_link,
            tolerance_position,
            tolerance_orientation,
            tolerance_joint_position,
            weight_position,
            weight_orientation,
            weight_joint_position,
            start_joint_state,
            cartesian,
            max_step,
        )
        if future is None:
            return None
        self._wait(future)
        return self.get_trajectory(future, cartesian, cartesian_fraction_threshold)

    def plan_async(
        self,
        pose: Any = None,
        position: Any = None,
        quat_xyzw: Any = None,
        joint_positions: Sequence[float] | None = None,
        joint_names: Sequence[str] | None = None,
        frame_id: str | None = None,
        target_link: str | None = None,
        tolerance_position: float = 0.001,
        tolerance_orientation: Any = 0.001,
        tolerance_joint_position: float = 0.001,
        weight_position: float = 1.0,
        weight_orientation: float = 1.0,
        weight_joint_position: float = 1.0,
        start_joint_state: Any = None,
        cartesian: bool = False,
        max_step: float = 0.0025,
    ) -> Any:
        """Return the future of a plan to what was set as a goal and to what is given here."""
        if pose is not None:
            placed = self._stamped(pose, None, None, frame_id)
            frame_id = placed.header.frame_id
            position, quat_xyzw = placed.pose.position, placed.pose.orientation
        if position is not None:
            self.set_position_goal(
                position, frame_id, target_link, tolerance_position, weight_position
            )
        if quat_xyzw is not None:
            self.set_orientation_goal(
                quat_xyzw, frame_id, target_link, tolerance_orientation, weight_orientation
            )
        if joint_positions is not None:
            self.set_joint_goal(
                joint_positions, joint_names, tolerance_joint_position, weight_joint_position
            )
        if start_joint_state is None:
            if self._state is None:
                self._warn("Joint states are not available yet!")
                wait_until(self._node, lambda: self._state is not None, "joint states of the group")
            start_joint_state = self.joint_state
        self._goal.request.start_state.joint_state = self._as_state(start_joint_state)
        future = (
            self._plan_cartesian_path(max_step, frame_id)
            if cartesian
            else self._plan_kinematic_path()
        )
        self.clear_goal_constraints()
        self.clear_path_constraints()
        return future

    def get_trajectory(
        self, future: Any, cartesian: bool = False, cartesian_fraction_threshold: float = 0.0
    ) -> Any:
        """Return the trajectory of a plan's future, None where it failed."""
        if not future.done():
            self._warn("Cannot get trajectory because future is not done.")
            return None
        answer = future.result() if cartesian else future.result().motion_plan_response
        if answer.error_code.val != MoveItErrorCodes.SUCCESS:
            code = enum_to_str(MoveItErrorCodes, answer.error_code.val)
            self._warn(f"Planning failed! Error code: {code}")
            return None
        if not cartesian:
            return answer.trajectory.joint_trajectory
        if answer.fraction < cartesian_fraction_threshold:
            self._warn(
                f"Planning failed! Cartesian planner completed {answer.fraction} of the "
                f"trajectory, less than the threshold {cartesian_fraction_threshold}."
            )
            return None
        return answer.solution.joint_trajectory

    def execute(self, joint_trajectory: Any) -> None:
        """Begin to execute a trajectory."""
        if self._is_skipped():
            return
        goal = init_execute_trajectory_goal(joint_trajectory)
        if goal is None:
            self._warn("Cannot execute motion because the provided/planned trajectory is invalid.")
            return
        self._send(self._execute_trajectory_action_client, goal)

    def wait_until_executed(self) -> bool:
        """Wait for the end of a motion, and return whether it succeeded."""
        if not self._is_requested and not self._is_executing:
            self._warn("Cannot wait until motion is executed (no motion is in progress).")
            return False
        wait_until(
            self._node,
            lambda: not self._is_requested and not self._is_executing,
            f"the end of a motion of {self._group}",
        )
        return self.motion_suceeded

    def reset_controller(self, joint_state: Any) -> None:
        """Send the joints to a state at once."""
        trajectory = init_dummy_joint_trajectory_from_state(self._as_state(joint_state))
        self._send(self._execute_trajectory_action_client, init_execute_trajectory_goal(trajectory))

    def force_reset_executing_state(self) -> None:
        """Forget that a motion is requested or executed."""
        self._is_requested = self._is_executing = False

    # Requests

    def _is_skipped(self) -> bool:
        if self._ignores_calls and (self._is_requested or self._is_executing):
            self._warn("Controller is already following a trajectory. Skipping motion.")
            return True
        return False

    def _take_state(self, msg: Any) -> None:
        if all(name in msg.name for name in self._joint_names):
            with self._mutex:
                self._state, self._has_new_state = msg, True

    def _plan_kinematic_path(self) -> Any:
        request = GetMotionPlan.Request(motion_plan_request=self._goal.request)
        if not self._is_ready(self._plan_kinematic_path_service):
            return None
        return self._plan_kinematic_path_service.call_async(request)

    def _plan_cartesian_path(self, max_step: float = 0.0025, frame_id: Any = None) -> Any:
        asked, request = self._cartesian_request, self._goal.request
        asked.start_state = request.start_state
        asked.group_name = request.group_name
        asked.max_step = max_step
        asked.header.frame_id = self._base_link if frame_id is None else frame_id
        asked.header.stamp = self._node.get_clock().now().to_msg()
        asked.path_constraints = request.path_constraints
        goal = request.goal_constraints[-1]
        for constraint in goal.position_constraints:
            asked.link_name = constraint.link_name
        asked.waypoints = [
            self._stamped(
                None,
                goal.position_constraints[-1].constraint_region.primitive_poses[0].position,
                goal.orientation_constraints[-1].orientation,
                frame_id,
            ).pose
        ]
        if hasattr(asked, "max_velocity_scaling_factor"):
            asked.max_velocity_scaling_factor = request.max_velocity_scaling_factor
            asked.max_acceleration_scaling_factor = request.max_acceleration_scaling_factor
        if not self._is_ready(self._plan_cartesian_path_service):
            return None
        return self._plan_cartesian_path_service.call_async(asked)

    def _send_move(self) -> None:
        if self.joint_state is not None:
            self._goal.request.start_state.joint_state = self.joint_state
        self._send(self._move_action_client, self._goal)
        self.clear_goal_constraints()
        self.clear_path_constraints()

    def _send(self, client: Any, goal: Any) -> None:
        self._is_requested = True
        if not client.server_is_ready() and not client.wait_for_server(timeout_sec=1.0):
            self._warn("Action server is not yet available.")
            self._is_requested = False
            return
        self._error_code = None
        client.send_goal_async(goal=goal).add_done_callback(self._answered)

    def _answered(self, future: Any) -> None:
        handle = future.result()
        if not handle.accepted:
            self._warn("The goal was rejected.")
            self._is_requested = False
            self.motion_suceeded = False
            return
        self._handle = handle
        self._is_executing, self._is_requested = True, False
        handle.get_result_async().add_done_callback(self._ended)

    def _ended(self, future: Any) -> None:
        answer = future.result()
        self._error_code = answer.result.error_code
        self.motion_suceeded = answer.status == GoalStatus.STATUS_SUCCEEDED
        if not self.motion_suceeded:
            self._warn(f"The motion was unsuccessful: {enum_to_str(GoalStatus, answer.status)}.")
        self._handle = None
        self._is_executing = False

    # What is set

    end_effector_name = property(attrgetter("_end_effector"), doc="The link of the end effector.")

    base_link_name = property(attrgetter("_base_link"), doc="The base link.")

    joint_names = property(attrgetter("_joint_names"), doc="The joints of the group.")

    @property
    def joint_state(self) -> Any:
        """The last joint states that hold all joints, None before."""
        with self._mutex:
            return self._state

    @property
    def new_joint_state_available(self) -> bool:
        """Whether joint states came since `reset_new_joint_state_checker`."""
        return self._has_new_state

    def reset_new_joint_state_checker(self) -> None:
        """Forget that joint states came."""
        with self._mutex:
            self._has_new_state = False
