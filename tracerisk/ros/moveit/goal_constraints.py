"""Goals as moveit_msgs/Constraints state them: states are sampled that meet all of them.

As MoveIt does: joints are taken from joint constraints; poses from the position and orientation
constraints of each link, whose inverse kinematics must then meet every constraint. The state is
the nearest that is found: the middle of what is allowed comes first, then samples from it.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import Any

from tracerisk.errors import RobotError, one_of
from tracerisk.ros.moveit.goal_regions import LinkRegion
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.ros.moveit.path_constraints import PathRule, message_pose
from tracerisk.ros.moveit.plan_records import Plan, PoseGoal, places
from tracerisk.ros.moveit.trajectory_execution import ErrorCode
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.transforms.poses import ORIGIN, unit_quaternion
from tracerisk.twin.motion.plausible_units import past_limits
from tracerisk.twin.physics.motion import PlanningError, Pose
from tracerisk.twin.robots.robot_parts import Joint, Scaling

_SLACK = 1e-3  # beyond a bound: what inverse kinematics comes to is within it [rad or m]
_SAMPLES = 12  # of where links may be, before a goal is given up
_KINDS = ("joint", "position", "orientation", "visibility")


class RequestError(Exception):
    """A request that move_group answers with an error code: `code`."""

    def __init__(self, code: ErrorCode, message: str) -> None:
        super().__init__(message)
        self.code = code


@dataclass(frozen=True, slots=True)
class JointBounds:
    """Where a joint is to be [rad or m]."""

    middle: float
    """The position that is asked for, or the nearest that all its constraints allow."""
    lower: float
    """The least that they allow."""
    upper: float
    """The greatest that they allow."""

    @classmethod
    def of(cls, one: Any, joint: Joint) -> JointBounds:
        """Return what a constraint allows a joint within its limits."""
        middle = float(one.position)
        lower, upper = middle - one.tolerance_below, middle + one.tolerance_above
        if joint.type != "continuous":
            lower, upper = max(lower, joint.lower), min(upper, joint.upper)
        return cls(min(max(middle, lower), upper), lower, upper)

    def within(self, other: JointBounds) -> JointBounds:
        """Return what both allow."""
        lower, upper = max(self.lower, other.lower), min(self.upper, other.upper)
        return JointBounds(min(max(self.middle, lower), upper), lower, upper)


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """One of the alternatives of a request: all of its constraints are to be met."""

    joints: Mapping[str, JointBounds]
    """The joints of the group that it constrains."""
    regions: tuple[LinkRegion, ...]
    """The links that it constrains, each with where it may be."""
    rule: PathRule
    """All constraints, to check a state by."""

    @property
    def poses(self) -> list[PoseGoal]:
        """The middle of where each link may be; none where no pose is in all its regions."""
        return next(self.samples(), [])

    def samples(self) -> Iterator[list[PoseGoal]]:
        """Yield poses of the links to try in turn."""
        samples = zip(*(region.samples() for region in self.regions), strict=False)
        is_wide = any(region.is_wide for region in self.regions)
        yield from map(list, islice(samples, _SAMPLES if is_wide else 1))


class GoalReader:
    """Reads goals by what a server knows of groups, links and frames.

    `read_poses` gets the poses that are asked for, with their frames.
    """

    def __init__(self, server: MoveGroupServer, read_poses: ReadPoses) -> None:
        self._server = server
        self._read_poses = read_poses

    def plan(
        self,
        group: str,
        alternatives: Sequence[Any],
        scaling: Scaling,
        start: Mapping[str, float] | None,
    ) -> Plan:
        """Plan to the first of several Constraints that can be met.

        Raises:
            RequestError: there is none, or one is ill-formed.
        """
        goals = self.goals(group, alternatives)
        sought = [goal.poses for goal in goals if goal.regions]
        asked = places(sought[:1])
        if not sought:
            joints = goals[0].joints
            asked = tuple(joints[name].middle for name in sorted(joints))
        states = [partial(self._states, group, goal, start) for goal in goals]
        plan = self._server.plan_to(group, states, asked, scaling, start)
        self._server.sought.note(group, sought, is_reached=plan.trajectory is not None)
        return plan

    def goals(self, group: str, alternatives: Sequence[Any]) -> list[Goal]:
        """Return what each of several Constraints asks for; empty ones are left out.

        Raises:
            RequestError: as `plan`.
        """
        goals = [
            self._goal(group, constraints)
            for constraints in alternatives
            if any(len(getattr(constraints, f"{kind}_constraints")) for kind in _KINDS)
        ]
        if not goals:
            raise RequestError(ErrorCode.INVALID_GOAL_CONSTRAINTS, "the request has no goal")
        return goals

    def _goal(self, group: str, constraints: Any) -> Goal:
        if constraints.visibility_constraints:
            raise RequestError(
                ErrorCode.INVALID_GOAL_CONSTRAINTS,
                "goals of visibility cannot be planned: the twin has no cameras",
            )
        by_link: dict[str, tuple[list[Any], list[Any]]] = {}
        for one in constraints.position_constraints:
            by_link.setdefault(one.link_name or self.tip(group), ([], []))[0].append(one)
        for one in constraints.orientation_constraints:
            by_link.setdefault(one.link_name or self.tip(group), ([], []))[1].append(one)
        regions = tuple(
            self._region(link, positions, turns) for link, (positions, turns) in by_link.items()
        )
        constraints = self._within_limits(constraints)
        rule = PathRule(
            constraints,
            self._server.forward,
            self._server.frame,
            link=self._server.end_effector_link(group) or "",
            slack=_SLACK,
        )
        return Goal(self._joints(group, constraints.joint_constraints), regions, rule)

    def _region(self, link: str, positions: Sequence[Any], turns: Sequence[Any]) -> LinkRegion:
        for one in positions:
            if not one.constraint_region.primitive_poses:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"the position constraint of link '{link}' has no primitive as its region",
                )
        for place, turn in zip(positions[:1], turns[:1], strict=False):
            if place.header.frame_id == turn.header.frame_id:
                middle = message_pose(place.constraint_region.primitive_poses[0]).position
                asked = turn.orientation
                turned = unit_quaternion((asked.x, asked.y, asked.z, asked.w))
                self.given(place.header.frame_id, Pose(middle, turned), link)
        for turn in turns:
            asked = turn.orientation
            self._read_poses.look_at_length((asked.x, asked.y, asked.z, asked.w))
        is_known = link in self._server.robot.link_names
        return LinkRegion(
            link,
            tuple((one, self.frame(one.header.frame_id)) for one in positions),
            tuple((one, self.frame(one.header.frame_id)) for one in turns),
            self._server.forward({}, link) if is_known else ORIGIN,
        )

    def _within_limits(self, constraints: Any) -> Any:
        """Return constraints with each joint on a limit for which all that they allow is past it.

        MoveIt takes them so, with a warning in its own log alone.
        """
        robot = self._server.robot
        joints = {joint.name: joint for joint in robot.joints}
        taken = copy.copy(constraints)
        taken.joint_constraints = []
        for one in constraints.joint_constraints:
            if one.joint_name not in joints:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"robot '{robot.name}' has no joint '{one.joint_name}'; "
                    f"{one_of(list(joints), one.joint_name)}",
                )
            if min(one.tolerance_below, one.tolerance_above) < 0.0:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"the constraint of joint '{one.joint_name}' has a negative tolerance; "
                    "give 0 or more",
                )
            joint, on_limit = joints[one.joint_name], copy.copy(one)
            taken.joint_constraints.append(on_limit)
            if joint.type == "continuous":
                continue
            if one.position + one.tolerance_above < joint.lower:
                on_limit.position, on_limit.tolerance_above = joint.lower, 0.0
            elif one.position - one.tolerance_below > joint.upper:
                on_limit.position, on_limit.tolerance_below = joint.upper, 0.0
            else:
                continue
            past = past_limits(joint, one.position, 0.0)
            words = f"MoveIt takes a goal of joint '{joint.name}' to {past}; it stops there"
            self._server.execution.report("stopped_at_limit", words, object_name=joint.name)
        return taken

    def _joints(self, group: str, constraints: Sequence[Any]) -> dict[str, JointBounds]:
        """Return where the group's joints are to be; those of other groups are left out."""
        robot = self._server.robot
        members = self._server.group(group).joints
        bounds: dict[str, JointBounds] = {}
        for one in constraints:
            if one.joint_name not in members:
                continue
            within = JointBounds.of(one, robot.joint(one.joint_name))
            if one.joint_name in bounds:
                within = bounds[one.joint_name].within(within)
            if within.lower > within.upper:
                raise RequestError(
                    ErrorCode.INVALID_GOAL_CONSTRAINTS,
                    f"the constraints of joint '{one.joint_name}' leave it no position",
                )
            bounds[one.joint_name] = within
        return bounds

    def _states(
        self, group: str, goal: Goal, start: Mapping[str, float] | None
    ) -> Iterator[dict[str, float]]:
        """Yield joint positions that meet a goal, nearest first.

        Raises:
            PlanningError: none were found.
        """
        joints = {name: bounds.middle for name, bounds in goal.joints.items()}
        if not goal.regions:
            there = self._server.with_others({**(start or {}), **joints})
            if outside := goal.rule.breach(there):
                raise PlanningError("invalid_goal", f"the goal cannot be met as a whole: {outside}")
            yield joints
            return
        also = {
            "breach": goal.rule.breach,
            "bounds": {name: (joint.lower, joint.upper) for name, joint in goal.joints.items()},
        }
        failure: PlanningError | None = None
        for poses in goal.samples():
            try:
                yield from self._server.reach_each(group, poses, start, **also)
            except PlanningError as error:
                failure = failure or error
            else:
                return
        raise failure or PlanningError("no_ik_solution", "the goal's constraints leave no pose")

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

    def given(self, frame: str, pose: Pose, link: str) -> None:
        """Take note of a pose that is asked for in a frame, for a link."""
        self._read_poses.given(frame, pose, link, self._server.known_frame)

    def frame(self, name: str) -> Pose:
        """Return the pose of a frame; raise RequestError for an unknown one."""
        pose = self._server.frame(name)
        if pose is None:
            raise RequestError(ErrorCode.FRAME_TRANSFORM_FAILURE, f"unknown frame '{name}'")
        return pose
