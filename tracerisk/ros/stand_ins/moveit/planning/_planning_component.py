"""PlanningComponent: where a planning group is to go, and the plan for it."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from moveit_msgs.msg import Constraints

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.goal_constraints import GoalReader, RequestError
from tracerisk.ros.moveit.plan_records import Plan
from tracerisk.ros.moveit.trajectory_execution import ErrorCode
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.twin.motion.plausible_units import floored_percent
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot_parts import Scaling

from .._library import library, log_error
from ..core.kinematic_constraints import _pose_constraint, construct_joint_constraint
from ..core.planning_interface import MotionPlanResponse
from ..core.planning_scene import PlanningScene
from ..core.robot_state import RobotState, robotStateToRobotStateMsg
from ..core.robot_trajectory import RobotTrajectory
from ._parameters import MultiPipelinePlanRequestParameters, PlanRequestParameters

if TYPE_CHECKING:
    from ._moveit_py import MoveItPy

_EXACT = 2.2e-16  # the tolerance of a goal that is a state, as in the real library [rad or m]
_LINE_STEP = 0.01  # between the points of a straight line [m]


class PlanningComponent:
    """Plans for one planning group of the robot.

    Raises:
        RuntimeError: the robot has no such group; lists those it has.
    """

    def __init__(self, joint_model_group_name: str, moveit_py_instance: MoveItPy) -> None:
        self._server = library().server
        self._moveit = moveit_py_instance
        self._model = moveit_py_instance.get_robot_model()
        groups = self._server.robot.groups
        if joint_model_group_name not in groups:
            raise RuntimeError(
                f"Could not find joint model group '{joint_model_group_name}'. "
                f"Groups of robot '{self._server.robot.name}': "
                f"{one_of(groups, joint_model_group_name)}"
            )
        self._name = joint_model_group_name
        self._start: RobotState | None = None
        self._goals: list[Any] = []
        self._path_constraints = Constraints()
        self._workspace: tuple[float, ...] | None = None
        self._reader = GoalReader(self._server, current().client(ReadPoses))

    @property
    def planning_group_name(self) -> str:
        """The name of the planning group."""
        return self._name

    @property
    def named_target_states(self) -> list[str]:
        """The names of the group's states."""
        return list(self._states())

    def get_named_target_state_values(self, name: str) -> dict[str, float]:
        """Return the joint positions of a named state; none where there is no such state."""
        return dict(self._states().get(name, {}))

    # Where plans start

    def set_start_state_to_current_state(self) -> None:
        """Start plans where the robot is when they are made."""
        self._start = None

    def set_start_state(
        self, configuration_name: str | None = None, robot_state: RobotState | None = None
    ) -> bool:
        """Start plans at a named state of the group, or a RobotState; return whether it is known.

        Raises:
            ValueError: both are given, or neither.
        """
        if configuration_name is not None and robot_state is not None:
            raise ValueError("Cannot specify both configuration name and robot state")
        if robot_state is not None:
            self._start = copy.copy(_a(RobotState, robot_state, "robot_state"))
            return True
        if configuration_name is None:
            raise ValueError("Must specify at least one argument")
        state = self._named(configuration_name)
        if state is not None:
            self._start = state
        return state is not None

    def get_start_state(self) -> RobotState:
        """Return where a plan would begin."""
        return self._moveit._monitor._state() if self._start is None else self._start

    # Where plans lead

    def set_goal_state(
        self,
        configuration_name: str | None = None,
        robot_state: RobotState | None = None,
        pose_stamped_msg: Any = None,
        pose_link: str | None = None,
        motion_plan_constraints: Sequence[Any] | None = None,
    ) -> bool:
        """Set the goal: a named state, a RobotState, a PoseStamped of a link, or Constraints.

        Returns False for the name of a state that there is not; the goal stays as it was, and
        the run has a finding that lists the states there are.

        Raises:
            ValueError: two of them are given, or none, or a pose without its link.
        """
        given = {
            "configuration name": configuration_name,
            "robot state": robot_state,
            "pose msg": pose_stamped_msg,
            "motion plan constraints": motion_plan_constraints,
        }
        named = [what for what, value in given.items() if value is not None]
        if len(named) > 1:
            raise ValueError(_both(named[0], named[1]))
        if (pose_stamped_msg is None) != (pose_link is None):
            raise ValueError("Must specify both message and corresponding link")
        if not named:
            raise ValueError("Must specify at least one argument")
        if configuration_name is not None:
            robot_state = self._named(configuration_name)
            if robot_state is None:
                return False
        if robot_state is not None:
            state = _a(RobotState, robot_state, "robot_state")
            group = self._model._group(self._name)
            self._goals = [construct_joint_constraint(state, group, _EXACT)]
        elif pose_link is not None:
            self._goals = [_pose_constraint(pose_stamped_msg, pose_link)]
        else:
            self._goals = [
                _a(Constraints, one, "motion_plan_constraints")
                for one in motion_plan_constraints or ()
            ]
        return True

    def set_path_constraints(self, path_constraints: Any) -> bool:
        """Set what plans must keep to on the way; a plan that does not is a failure."""
        self._path_constraints = _a(Constraints, path_constraints, "path_constraints")
        return True

    def set_workspace(
        self, min_x: float, min_y: float, min_z: float, max_x: float, max_y: float, max_z: float
    ) -> None:
        """Set the workspace; as in the real library it binds mobile bases only."""
        self._workspace = tuple(map(float, (min_x, min_y, min_z, max_x, max_y, max_z)))

    def unset_workspace(self) -> None:
        """Forget the workspace."""
        self._workspace = None

    # Plan

    def plan(
        self,
        single_plan_parameters: PlanRequestParameters | None = None,
        multi_plan_parameters: MultiPipelinePlanRequestParameters | None = None,
        planning_scene: PlanningScene | None = None,
        solution_selection_function: Callable[[list[MotionPlanResponse]], Any] | None = None,
        stopping_criterion_callback: Any = None,
    ) -> MotionPlanResponse:
        """Plan from the start to the goal, without moving.

        With parameters of several pipelines each plans, and the shortest path is returned, or
        the one that `solution_selection_function` takes from the list of them all.

        Raises:
            ValueError: both kinds of parameters are given, or a scene without parameters.
            TypeError: a stopping criterion is given; its argument has no form in Python.
        """
        if single_plan_parameters is not None and multi_plan_parameters is not None:
            raise ValueError("Cannot specify both single and multi plan parameters")
        if stopping_criterion_callback is not None:
            raise TypeError(
                "stopping_criterion_callback cannot be called: the real library has no form in "
                "Python for the responses it is given; leave it out"
            )
        if multi_plan_parameters is not None:
            several = _a(
                MultiPipelinePlanRequestParameters, multi_plan_parameters, "multi_plan_parameters"
            )
            return self._plan_all(
                several.multi_plan_request_parameters, planning_scene, solution_selection_function
            )
        if single_plan_parameters is not None:
            one = _a(PlanRequestParameters, single_plan_parameters, "single_plan_parameters")
            return self._plan_one(one, planning_scene)
        if planning_scene is not None:
            raise ValueError("Cannot specify planning scene without specifying plan parameters")
        return self._plan_one(PlanRequestParameters(self._moveit), None)

    def _plan_all(
        self,
        parameters: Sequence[PlanRequestParameters],
        scene: PlanningScene | None,
        select: Callable[[list[MotionPlanResponse]], Any] | None,
    ) -> MotionPlanResponse:
        # The same parameters give the same plan: each is made once.
        distinct = {parameter._key(): parameter for parameter in parameters}
        answers = {key: self._plan_one(item, scene) for key, item in distinct.items()}
        responses = [answers[parameter._key()] for parameter in parameters]
        if not responses:
            return self._response(Plan(ErrorCode.INVALID_GOAL_CONSTRAINTS, None), None, "")
        if select is not None:
            chosen = select(responses)
            response: MotionPlanResponse = _a(
                MotionPlanResponse, chosen, "solution_selection_function()"
            )
            return response
        return min(responses, key=_path_length)

    def _plan_one(
        self, parameters: PlanRequestParameters, scene: PlanningScene | None
    ) -> MotionPlanResponse:
        start = None if self._start is None else self._start.joint_positions
        if scene is None:
            self._moveit._monitor.update_frame_transforms()
            plan = self._planned(parameters, start)
        else:
            with _a(PlanningScene, scene, "planning_scene")._in_force(None):
                plan = self._planned(parameters, start)
        return self._response(plan, start, parameters.planner_id)

    def _planned(
        self, parameters: PlanRequestParameters, start: Mapping[str, float] | None
    ) -> Plan:
        scaling = parameters._scaling()
        try:
            if not self._goals:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS, "no goal is set; call set_goal_state"
                )
            if parameters.planner_id == "CIRC":
                raise RequestError(
                    ErrorCode.PLANNING_FAILED,
                    "the planner CIRC is not provided; plan arcs as short lines by LIN",
                )
            with self._server.planning_under(self._path_constraints):
                if parameters.planner_id == "LIN":
                    return self._line(scaling, start)
                return self._reader.plan(self._name, self._goals, scaling, start)
        except RequestError as error:
            self._report(str(error))
            return Plan(error.code, None, str(error))

    def _line(self, scaling: Scaling, start: Mapping[str, float] | None) -> Plan:
        """Plan a straight line of the goal's link, as the planner LIN of pilz does."""
        link, pose = self._line_end(start)
        plan, fraction = self._server.plan_cartesian(
            self._name, [pose], link=link, eef_step=_LINE_STEP, start=start, scaling=scaling
        )
        if plan.trajectory is None:
            return plan
        if fraction < 1.0:
            raise RequestError(
                ErrorCode.PLANNING_FAILED,
                f"the straight line of '{link}' ends after {floored_percent(fraction)} of its way",
            )
        return plan

    def _line_end(self, start: Mapping[str, float] | None) -> tuple[str, Pose]:
        for goal in self._reader.goals(self._name, self._goals):
            if not goal.regions:
                link = self._reader.tip(self._name)
                target = {name: bounds.middle for name, bounds in goal.joints.items()}
                return link, self._server.forward({**(start or {}), **target}, link)
            poses = goal.poses
            if len(poses) == 1 and poses[0].kind == "pose" and not goal.joints:
                return poses[0].link, poses[0].pose
        raise RequestError(
            ErrorCode.INVALID_GOAL_CONSTRAINTS, "a straight line needs the whole pose of one link"
        )

    def _response(
        self, plan: Plan, start: Mapping[str, float] | None, planner_id: str
    ) -> MotionPlanResponse:
        state = self._moveit._monitor._state()
        if start is not None:
            state._take(start)
        trajectory = None
        if plan.trajectory is not None:
            trajectory = RobotTrajectory(self._model)
            trajectory.joint_model_group_name = self._name
            trajectory._fill(plan.trajectory, state)
        message = robotStateToRobotStateMsg(state)
        return MotionPlanResponse._of(
            _code=int(plan.code),
            _trajectory=trajectory,
            _start_state=message,
            _planner_id=planner_id,
        )

    def _report(self, reason: str) -> None:
        message = f"planning for group '{self._name}' failed: {reason}"
        self._server.execution.report("planning_failure", message, object_name=self._name)

    def _states(self) -> Mapping[str, Mapping[str, float]]:
        return self._server.robot.named_states.get(self._name, {})

    def _named(self, name: str) -> RobotState | None:
        """Return a named state; None, with an error in the log, where there is none."""
        states = self._states()
        if name not in states:
            message = (
                f"No predefined joint state found for target name '{name}' of group "
                f"'{self._name}'; {one_of(states, name)}"
            )
            log_error(message)
            self._server.execution.report("planning_failure", message, object_name=self._name)
            return None
        state = RobotState(self._model)
        state.set_to_default_values()
        state._take(states[name])
        return state


def _a(kind: Any, value: Any, name: str) -> Any:
    if not isinstance(value, kind):
        raise TypeError(
            f"incompatible function arguments: {name} takes {kind.__name__}, "
            f"not {type(value).__name__}"
        )
    return value


def _both(one: str, two: str) -> str:
    if (one, two) == ("pose msg", "motion plan constraints"):
        one = "pose goal"
    return f"Cannot specify both {one} and {two}"


def _path_length(response: MotionPlanResponse) -> float:
    """Return the sum of the joints' ways [rad or m]; infinite where there is no path."""
    if response.trajectory is None:
        return float("inf")
    states = [list(state._positions.values()) for state, _ in response.trajectory]
    return sum(math.dist(one, two) for one, two in pairwise(states))
