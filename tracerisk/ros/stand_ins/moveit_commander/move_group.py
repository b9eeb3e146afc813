"""MoveGroupCommander: plan and execute for one planning group."""

import contextlib
import re
from collections.abc import Sequence
from contextlib import nullcontext
from numbers import Integral, Real
from typing import Any

import numpy as np
from geometry_msgs.msg import Pose
from moveit_msgs.msg import (
    Constraints,
    MotionPlanRequest,
    MoveItErrorCodes,
    RobotState,
    RobotTrajectory,
)

from tracerisk.config import PACKAGE_FILE
from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit import messages
from tracerisk.ros.moveit.plan_records import Plan, PoseGoal
from tracerisk.ros.moveit.trajectory_execution import Asker, ErrorCode
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError
from tracerisk.twin.robots.robot_parts import Scaling

from . import conversions
from ._binding import check_arguments, received
from ._pick_place import GroupPickPlace
from ._server import report_unknown, server
from .exception import MoveItCommanderException

_RETIMING = (
    "iterative_time_parameterization",
    "iterative_spline_parameterization",
    "time_optimal_trajectory_generation",
)


class PlanResult(tuple[bool, Any, float, Any]):
    """(success, RobotTrajectory, planning time [s], MoveItErrorCodes), as plan() returns.

    Up to ROS Melodic plan() returned the RobotTrajectory alone; programs written for that read
    `joint_trajectory` of the result, so it has the trajectory's fields too where nothing says that
    they are for Noetic.
    """

    @property
    def held_message(self) -> Any:
        """The RobotTrajectory, where it is a field of a message."""
        _take_as_older_plan("joint_trajectory")
        return self[1]

    @property
    def joint_trajectory(self) -> Any:
        """The planned joint trajectory."""
        _take_as_older_plan("joint_trajectory")
        return self[1].joint_trajectory

    @property
    def multi_dof_joint_trajectory(self) -> Any:
        """The planned trajectory of joints with several degrees of freedom; empty."""
        _take_as_older_plan("multi_dof_joint_trajectory")
        return self[1].multi_dof_joint_trajectory


def _take_as_older_plan(attribute: str) -> None:
    """Report that a plan was read as before Noetic, unless the controller is known to be for that.

    Raises:
        AttributeError: the controller is known to be for Noetic.
    """
    distro = current().distro
    if distro.precedes_noetic:
        return
    if distro.value("plan-is-tuple") and not distro.is_assumed:
        raise AttributeError(f"'tuple' object has no attribute '{attribute}'")
    server().execution.report(
        "distro_assumed",
        "plan() is taken for what it returned up to ROS Melodic, the trajectory; in Noetic it "
        "returns (success, trajectory, planning_time, error_code), and this raises "
        "AttributeError: use plan()[1]",
        object_name="plan",
    )


_SETTLED = "; moveit_release in [tool.tracerisk] names the release that runs, ros_distro does not"
"""How a user settles which release of MoveIt a call is for."""
_BEFORE_NOETIC = (1, 0)
"""The last releases of MoveIt before those for Noetic, which begin with 1.1."""


def _path_arguments(*given: Any, **named: Any) -> tuple[Any, Any]:
    """Return `avoid_collisions` and `path_constraints` of a call of compute_cartesian_path.

    Noetic was released with `jump_threshold` before them and lost it with MoveIt 1.1.15, so either
    form is evidence of the program's version, unless a setting or a moveit_commander names it.
    """
    has_threshold_first = bool(given) and (
        (isinstance(given[0], Real) and not isinstance(given[0], Integral))
        or (len(given) > 1 and isinstance(given[1], bool))
        or len(given) > 2
        or "avoid_collisions" in named
        or ("path_constraints" in named and len(given) > 1)
    )
    is_older = has_threshold_first or "jump_threshold" in named
    if is_older and _take_as_older(
        "compute_cartesian_path",
        "compute_cartesian_path() is taken for what it was before MoveIt 1.1.15, with "
        "jump_threshold; from that release on its arguments are (waypoints, eef_step, "
        "avoid_collisions, path_constraints), and this raises an error: leave jump_threshold out",
        (1, 1, 15),
    ):
        named.pop("jump_threshold", None)
        given = given[1:] if has_threshold_first else given
    return _present_path_arguments(*given, **named)


def _moveit_release() -> tuple[int, ...] | None:
    """Return the release of MoveIt: of the settings, else of the moveit_commander that is here.

    Where neither names one, it is the last that a ROS 1 before Noetic had, for a program for such a
    one, else `None`.
    """
    runtime = current()
    text = "" if runtime.moveit_release is None else f"<version>{runtime.moveit_release}"
    folder = runtime.findable.get("moveit_commander")
    if not text and folder is not None:
        with contextlib.suppress(OSError):
            text = (folder / PACKAGE_FILE).read_text(encoding="utf-8", errors="replace")
    matched = re.search(r"<version>\s*(\d+)\.(\d+)\.(\d+)", text)
    if matched is None:
        return _BEFORE_NOETIC if runtime.distro.precedes_noetic else None
    return tuple(map(int, matched.groups()))


def _take_as_older(call: str, words: str, until: tuple[int, ...]) -> bool:
    """Return whether arguments are taken that MoveIt had before a release, and say so.

    `words` are for where nothing names the release that runs.
    """
    release = _moveit_release()
    if release is None:
        server().execution.report("distro_assumed", f"{words}{_SETTLED}", object_name=call)
    return release is None or release < until


def _present_path_arguments(
    avoid_collisions: Any = True, path_constraints: Any = None
) -> tuple[Any, Any]:
    return avoid_collisions, path_constraints


def _execute_arguments(trajectory: Any, wait: bool = True) -> tuple[Any, bool]:
    return trajectory, wait


_execute_arguments.__name__ = _execute_arguments.__qualname__ = "execute"
_present_path_arguments.__name__ = "compute_cartesian_path"
_present_path_arguments.__qualname__ = _present_path_arguments.__name__


def _check_is_message(trajectory: Any) -> None:
    """Raise AttributeError for what cannot be written as a JointTrajectory."""
    for field in ("header", "joint_names", "points"):
        getattr(trajectory, field)


class MoveGroupCommander(GroupPickPlace):
    """A client of move_group for one planning group of the robot.

    `robot_description` names the parameters of the default scaling factors. `ns` and
    `wait_for_servers` are taken and change nothing: there is one robot, and its server is there
    at once. What the program made before is connected when the commander is made.

    Raises:
        RuntimeError: the robot has no such group; lists those it has.
    """

    def __init__(
        self,
        name: str,
        robot_description: str = "robot_description",
        ns: str = "",
        wait_for_servers: float = 5.0,
    ) -> None:
        super().__init__(name, robot_description)
        # It loads the robot and waits for move_group, which takes longer than any connection.
        current().graph.carrier.pass_connections()

    # Plan and move

    def go(self, joints: Any = None, wait: bool = True) -> bool:
        """Plan to a target and move there; return whether it was reached.

        `joints` is a target as set_joint_value_target takes it, a Pose, the name of remembered
        joint values, or None for the target that is set. With `wait=False` the answer is True
        as soon as the request is sent.

        Raises:
            MoveItCommanderException: the target is refused when it is set.
        """
        if isinstance(joints, bool):
            wait, joints = joints, None
        if isinstance(joints, str) and joints in self._remembered:
            joints = self._remembered[joints]
        self._set_target(joints)
        runtime = current()
        carrier, scheduler = runtime.graph.carrier, runtime.scheduler
        planning_ns = 0 if wait else carrier.planning_ns()
        # move_group plans while who does not wait goes on.
        with scheduler.kernel() if planning_ns else nullcontext():
            plan = self._plan()
        trajectory = plan.trajectory
        if trajectory is None:
            self._server.execution.give_way("move_action")
            self._server.execution.refuse(plan.code)
            return not wait
        if planning_ns:
            due_ns = scheduler.now_ns + planning_ns
            carrier.at(due_ns, lambda: self._execute(trajectory, "move_action", wait=False))
            return True
        return self._execute(trajectory, "move_action", wait)

    def plan(self, joints: Any = None) -> PlanResult:
        """Plan to a target, as go() takes it, without moving.

        Raises:
            KeyError: no joint values are remembered under a name.
        """
        self._set_target(self._remembered[joints] if isinstance(joints, str) else joints)
        plan = self._plan()
        # It is a goal of the same action as that of go().
        self._server.execution.give_way("move_action")
        message = RobotTrajectory()
        if plan.trajectory is not None:
            frame = self.get_planning_frame()
            message = conversions._trajectory_message(plan.trajectory, frame)
        code = MoveItErrorCodes(val=int(plan.code))
        # The twin's planner takes no simulated time.
        return PlanResult((plan.code is ErrorCode.SUCCESS, message, 0.0, code))

    def execute(self, *given: Any, **named: Any) -> bool:
        """Execute a RobotTrajectory or JointTrajectory; return whether it was carried out.

        The arguments are (trajectory, wait=True). Releases before 1.1.12 called the first one
        `plan_msg`, which is taken unless the workspace has a later moveit_commander.

        Raises:
            AttributeError: it is neither.
            RuntimeError: it has a trajectory, but is a message of another type.
            TypeError: there are other arguments.
        """
        if "plan_msg" in named and _take_as_older(
            "execute",
            "execute() is taken for what it was before MoveIt 1.1.12, with plan_msg; from that "
            "release on the argument is trajectory, and this raises TypeError: give the plan "
            "without a name",
            (1, 1, 12),
        ):
            named["trajectory"] = named.pop("plan_msg")
        trajectory, wait = _execute_arguments(*given, **named)
        if isinstance(trajectory, PlanResult):
            _take_as_older_plan("serialize")
            trajectory = trajectory[1]
        elif not hasattr(trajectory, "joint_trajectory"):
            _check_is_message(trajectory)
            trajectory = RobotTrajectory(joint_trajectory=trajectory)
        trajectory = received(RobotTrajectory, trajectory)
        return self._execute(conversions._twin_trajectory(trajectory), "execute_trajectory", wait)

    def stop(self) -> None:
        """Stop what move_group is executing."""
        self._server.execution.stop()

    def compute_cartesian_path(
        self,
        waypoints: Sequence[Any],
        eef_step: float,
        *others: Any,
        **named: Any,
    ) -> tuple[Any, float]:
        """Plan straight lines of the end effector through poses, in steps of `eef_step` [m].

        Returns the RobotTrajectory and the fraction of the way that it covers. It is timed for
        the rated speeds whatever the scaling factors, as MoveIt does; see retime_trajectory.
        The other arguments are `avoid_collisions` and `path_constraints`. Releases before 1.1.15
        had `jump_threshold` before them, which is taken and reported unless the release is known.
        The path ends in any case where the joints would have to jump.

        Raises:
            ArgumentError: an argument is of another type.
            MoveItCommanderException: the constraints are no Constraints.
            TypeError: there are more arguments, or others.
        """
        avoid_collisions, path_constraints = _path_arguments(*others, **named)
        if path_constraints and not isinstance(path_constraints, Constraints):
            raise MoveItCommanderException(
                f"Unable to set path constraints, unknown constraint type {type(path_constraints)}"
            )
        listed = [conversions.pose_to_list(one) for one in waypoints]
        check_arguments(
            "compute_cartesian_path",
            (listed, "boost::python::list"),
            (eef_step, "double"),
            (avoid_collisions, "bool"),
        )
        link = self._link("", "plan a path for")
        poses = []
        for waypoint in listed:
            goal = self._pose_goal_or_none(link, waypoint)
            if goal is None:
                return RobotTrajectory(), -1.0
            poses.append(goal.pose)
        with self._server.planning_under(path_constraints or Constraints()):
            plan, fraction = self._server.plan_cartesian(
                self._name,
                poses,
                link=link,
                eef_step=float(eef_step),
                avoid_collisions=bool(avoid_collisions),
                start=self._start(),
            )
        if plan.trajectory is None:
            return RobotTrajectory(), fraction
        trajectory = self._within_speed(plan.trajectory)
        return conversions._trajectory_message(trajectory, self.get_planning_frame()), fraction

    def retime_trajectory(
        self,
        ref_state_in: Any,
        traj_in: Any,
        velocity_scaling_factor: float = 1.0,
        acceleration_scaling_factor: float = 1.0,
        algorithm: str = "iterative_time_parameterization",
    ) -> Any:
        """Return a RobotTrajectory timed anew for fractions of the rated speeds.

        The twin has one way to do it, whichever of MoveIt's three `algorithm` names.

        Raises:
            AttributeError: an argument that is to be a message is none.
            RuntimeError: it is a message of another type.
            ArgumentError: another argument is of another type.
            DeserializationError: the state names no joint.
        """
        state, traj_in = received(RobotState, ref_state_in), received(RobotTrajectory, traj_in)
        check_arguments(
            "retime_trajectory",
            (velocity_scaling_factor, "double"),
            (acceleration_scaling_factor, "double"),
            (algorithm, "std::string"),
        )
        if not state.is_diff and not state.joint_state.name:
            # The binding answers nothing for a state that it cannot take.
            return RobotTrajectory().deserialize(b"")
        if algorithm not in _RETIMING:
            message = f"Unknown time parameterization algorithm: {algorithm}; {one_of(_RETIMING)}"
            self._server.execution.report("planning_failure", message)
            return RobotTrajectory()
        scaling = Scaling(velocity_scaling_factor, acceleration_scaling_factor)
        try:
            timed = self._server.retime(conversions._twin_trajectory(traj_in), scaling)
        except PlanningError as error:
            message = f"a trajectory cannot be timed anew: {error.message}"
            self._server.execution.report("planning_failure", message)
            return RobotTrajectory()
        return conversions._trajectory_message(timed, self.get_planning_frame())

    def construct_motion_plan_request(self) -> Any:
        """Return the request that plan() would send, as a MotionPlanRequest."""
        request = MotionPlanRequest(
            group_name=self._name,
            num_planning_attempts=self._planning_attempts,
            max_velocity_scaling_factor=self._scaling.velocity,
            max_acceleration_scaling_factor=self._scaling.acceleration,
            allowed_planning_time=self._planning_time,
            planner_id=self._planner_id,
            pipeline_id=self._pipeline_id,
            workspace_parameters=self._workspace,
            path_constraints=self._path_constraints,
            trajectory_constraints=self._trajectory_constraints,
            start_state=self._start_message(),
        )
        if self._speed_limit is not None:
            request.max_cartesian_speed, request.cartesian_speed_limited_link = self._speed_limit
        request.goal_constraints = self._goal_constraints()
        return request

    # Objects

    def attach_object(
        self, object_name: str, link_name: str = "", touch_links: Sequence[str] | None = None
    ) -> bool:
        """Attach an object of the planning scene to a link (the end effector); True when asked.

        As with MoveIt the answer does not say whether there is such an object; where there is
        none, the run has a finding.

        Raises:
            ArgumentError: a name is no string, or the links that may touch it are no list.
        """
        touch_links = [] if touch_links is None else touch_links
        check_arguments(
            "attach_object",
            (object_name, "std::string"),
            (link_name, "std::string"),
            (touch_links, "boost::python::list"),
        )
        links = self._server.group_links(self._name)
        link = link_name or self._end_effector_link or (links[0] if links else "")
        if not link:
            return False
        with self._server.by_topic():
            is_attached = self._server.attach(object_name, link, touch_links or [link])
        if not is_attached:
            text = report_unknown(object_name, "attached")
            if object_name not in self._server.scene.attached:
                self._server.lack(object_name, text)
        return True

    def detach_object(self, name: str = "") -> bool:
        """Detach an object, or all those attached to a link, or to any link of the group.

        Raises:
            ArgumentError: the name is no string.
        """
        check_arguments("detach_object", (name, "std::string"))
        attached = dict(self._server.scene.attached)
        links = self._server.group_links(self._name)
        with self._server.by_topic():
            for object_name, item in attached.items():
                if name in (object_name, item.link) or (not name and item.link in links):
                    self._server.detach(object_name)
        return True

    # How

    def _set_target(self, joints: Any) -> None:
        if isinstance(joints, Pose):
            self.set_pose_target(joints)
        elif joints is not None:
            self.set_joint_value_target(joints)

    def _plan(self) -> Plan:
        try:
            start = self._start()
            with self._server.planning_under(self._path_constraints):
                if self._target_kind == "joint":
                    plan = self._server.plan_joints(
                        self._name, self._joint_target, self._scaling, start
                    )
                else:
                    goals = self._pose_goals(self._target_kind)
                    plan = self._server.plan_pose(self._name, goals, self._scaling, start)
        except PlanningError as error:
            text = f"planning for group '{self._name}' failed: {error.message}"
            self._server.execution.report("planning_failure", text, object_name=self._name)
            return Plan(ErrorCode.FRAME_TRANSFORM_FAILURE, None, error.message)
        if plan.trajectory is None:
            return plan
        return Plan(plan.code, self._within_speed(plan.trajectory), plan.message)

    def _execute(self, trajectory: JointTrajectory, by: Asker, wait: bool) -> bool:
        execution = self._server.execution.start(trajectory, by=by, preempts=True)
        if isinstance(execution, ErrorCode):
            return not wait or execution is ErrorCode.SUCCESS
        if not wait:
            return True
        return self._server.execution.wait(execution) is ErrorCode.SUCCESS

    def _within_speed(self, trajectory: JointTrajectory) -> JointTrajectory:
        """Return the trajectory, slowed down as a whole until the limited link keeps its limit."""
        if self._speed_limit is None or len(trajectory.time) < 2:
            return trajectory
        limit, link = self._speed_limit
        named = link or self._link("", "limit the speed of")
        places = np.array(
            [
                self._server.forward(
                    dict(zip(trajectory.joints, map(float, row), strict=True)), named
                ).position
                for row in trajectory.position
            ]
        )
        speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(trajectory.time)
        slower = max(1.0, float(speeds.max()) / limit)
        return JointTrajectory(
            trajectory.joints,
            trajectory.time * slower,
            trajectory.position,
            trajectory.velocity / slower,
        )

    def _pose_goal_or_none(self, link: str, waypoint: Any) -> PoseGoal | None:
        try:
            return self._pose_goal(link, self._framed(waypoint, link), "pose")
        except PlanningError as error:
            text = f"a waypoint: {error.message}"
            self._server.execution.report("planning_failure", text, object_name=self._name)
            return None

    def _start_message(self) -> Any:
        if self._start_state is None:
            return RobotState(is_diff=True)
        return conversions._state_message(self._start_state, self.get_planning_frame())

    def _goal_constraints(self) -> list[Any]:
        if self._target_kind == "joint":
            joints = [
                messages.joint_constraint(name, value, self._joint_tolerance)
                for name, value in self._joint_target.items()
            ]
            return [Constraints(joint_constraints=joints)]
        return [
            Constraints(
                position_constraints=[
                    self._position_constraint(goal) for goal in goals if goal.kind != "orientation"
                ],
                orientation_constraints=[
                    self._orientation_constraint(goal) for goal in goals if goal.kind != "position"
                ],
            )
            for goals in self._pose_goals(self._target_kind)
        ]

    def _position_constraint(self, goal: PoseGoal) -> Any:
        pose = conversions.list_to_pose([*goal.pose.position, 0.0, 0.0, 0.0, 1.0])
        frame, radius = self.get_planning_frame(), goal.position_tolerance
        return messages.position_constraint(frame, goal.link, pose, radius)

    def _orientation_constraint(self, goal: PoseGoal) -> Any:
        turn = conversions.list_to_pose([0.0, 0.0, 0.0, *goal.pose.orientation]).orientation
        frame, tolerances = self.get_planning_frame(), (goal.orientation_tolerance,) * 3
        return messages.orientation_constraint(frame, goal.link, turn, tolerances)
