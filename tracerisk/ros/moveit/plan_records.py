"""Goals and results of plans, as clients of move_group give and get them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from tracerisk.ros.moveit.trajectory_execution import ErrorCode
from tracerisk.twin.physics.motion import JointTrajectory, LinkTarget, PlanningFailure, Pose
from tracerisk.twin.robots.robot_parts import Scaling

if TYPE_CHECKING:
    from tracerisk.ros.graph.parameters import ParameterTree

_FREE_POSITION = 1e3  # a position tolerance that any position meets [m]
_FREE_ORIENTATION = 10.0  # an orientation tolerance that any orientation meets [rad]

GoalKind = Literal["pose", "position", "orientation"]

CODE_OF: Mapping[PlanningFailure, ErrorCode] = {
    "invalid_goal": ErrorCode.INVALID_GOAL_CONSTRAINTS,
    "no_ik_solution": ErrorCode.PLANNING_FAILED,
    "no_plan": ErrorCode.PLANNING_FAILED,
    "collision": ErrorCode.GOAL_IN_COLLISION,
    "start_in_collision": ErrorCode.START_STATE_IN_COLLISION,
    "bad_request": ErrorCode.INVALID_MOTION_PLAN,
}
"""As move_group answers a request for a plan: a pose without a solution is a plan not found."""


@dataclass(frozen=True, slots=True)
class PoseGoal:
    """The goal pose of a link."""

    link: str
    """The name of the link."""
    pose: Pose
    """The pose in the planning frame."""
    kind: GoalKind = "pose"
    """Which part of the pose counts."""
    position_tolerance: float = 1e-4
    """The greatest allowed distance from the position [m]."""
    orientation_tolerance: float = 1e-3
    """The greatest allowed angle from the orientation [rad]."""

    def target(self, here: Pose) -> LinkTarget:
        """Return the pose to look for, and how near counts.

        The part not asked for stays near `here`, where the link is.
        """
        if self.kind == "position":
            free = Pose(self.pose.position, here.orientation)
            return LinkTarget(self.link, free, orientation_tolerance=_FREE_ORIENTATION)
        if self.kind == "orientation":
            free = Pose(here.position, self.pose.orientation)
            return LinkTarget(self.link, free, position_tolerance=_FREE_POSITION)
        return LinkTarget(self.link, self.pose)

    def widened(self, target: LinkTarget) -> LinkTarget:
        """Return a target of this goal with all that its tolerances allow."""
        return replace(
            target,
            position_tolerance=max(target.position_tolerance, self.position_tolerance),
            orientation_tolerance=max(target.orientation_tolerance, self.orientation_tolerance),
        )


WHOLE_PATH = 0.999
"""A Cartesian path of which less is covered was cut."""

RATED = Scaling(1.0, 1.0)
"""The scaling at which plans keep the rated speeds."""


def valid_fraction(value: float) -> float:
    """Return a scaling factor as MoveIt's time parameterization takes it.

    What is not within (0, 1] is 1; that includes the 0 of a field of a message that is not set.
    Source: MotionPlanRequest.msg of moveit_msgs, and verifyScalingFactor in MoveIt's
    time_optimal_trajectory_generation.cpp.
    """
    return float(value) if 0.0 < value <= 1.0 else 1.0


@dataclass(frozen=True, slots=True)
class Plan:
    """The result of planning."""

    code: ErrorCode
    """The code that move_group answers with."""
    trajectory: JointTrajectory | None
    """The planned motion; `None` unless the code is SUCCESS."""
    message: str = ""
    """Why planning failed, in words; empty where it succeeded."""


def default_scaling(parameters: ParameterTree, description: str, default: Scaling) -> Scaling:
    """Return the fractions that a client of move_group plans with until it sets others.

    As MoveGroupInterface: `<description>_planning/default_velocity_scaling_factor` and
    `default_acceleration_scaling_factor` of the parameter server, which joint_limits.yaml
    sets, else `default`, those of the robot, 0.1 unless its description says otherwise. What is not
    within (0, 1] the time parameterization then takes as 1.
    """
    values = [default.velocity, default.acceleration]
    for i, kind in enumerate(("velocity", "acceleration")):
        name = f"/{description}_planning/default_{kind}_scaling_factor"
        value = parameters.get(name) if parameters.has(name) else None
        if isinstance(value, int | float) and not isinstance(value, bool):
            values[i] = valid_fraction(value)
    return Scaling(*values)


def places(goals: Sequence[Sequence[PoseGoal]]) -> tuple[float, ...]:
    """Return the positions of the first alternative: a retry may turn the tool."""
    return tuple(value for goal in next(iter(goals), ()) for value in goal.pose.position)


def last_place(poses: Sequence[Pose]) -> tuple[float, ...]:
    """Return the position of the last pose; empty without one."""
    return tuple(poses[-1].position) if poses else ()
