"""The targets of a planning group: joint positions, and poses of links."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from geometry_msgs.msg import Pose, PoseStamped
from sensor_msgs.msg import JointState

from tracerisk.errors import one_of
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.moveit.plan_records import GoalKind, PoseGoal
from tracerisk.ros.readings.euler_angles import look_at_euler
from tracerisk.ros.readings.read_poses import ReadPoses
from tracerisk.ros.transforms.poses import (
    Quaternion,
    compose,
    goal_quaternion,
    quaternion_from_rpy,
    rpy_from_quaternion,
    unit_quaternion,
)
from tracerisk.twin.motion.plausible_units import shown_limits
from tracerisk.twin.physics import motion
from tracerisk.twin.physics.motion import PlanningError
from tracerisk.twin.robots.generic import NAME
from tracerisk.twin.robots.robot_parts import Joint

from . import conversions
from ._binding import check_arguments, doubles
from ._group_state import GroupState
from .exception import MoveItCommanderException

_OUT_OF_BOUNDS = "Error setting joint target. Is the target within bounds?"


@dataclass(frozen=True, slots=True)
class _FramedPose:
    """A pose with its frame."""

    frame: str
    """The frame of the pose; empty: the planning frame."""
    pose: motion.Pose
    """The pose in the frame."""


class GroupTargets(GroupState):
    """What the next plan is for: the target that was set last."""

    def __init__(self, name: str, robot_description: str = "robot_description") -> None:
        super().__init__(name, robot_description)
        self._target_kind: Literal["joint"] | GoalKind = "joint"
        self._joint_target = self._server.default_target(name)
        self._pose_targets: dict[str, list[_FramedPose]] = {}
        self._remembered: dict[str, list[float]] = {}

    # Joint positions

    def get_joint_value_target(self) -> list[float]:
        """Return the joint target, with the joints that follow another [rad or m]."""
        led = self._server.robot.with_followers(self._joint_target)
        return [led.get(name, 0.0) for name in self._server.variables(self._name)]

    def set_joint_value_target(self, arg1: Any, arg2: Any = None, arg3: Any = None) -> None:
        """Set joint positions as the target.

        `arg1` is a dict, a list or a JointState; or a joint's name, with its position as `arg2`;
        or a Pose or PoseStamped, whose joint positions are looked for at once, with the link as
        `arg2` or `arg3` and whether it may be approximate as the other.

        Raises:
            MoveItCommanderException: it is of another type, a RobotState say; a name is not of the
                group, a value is out of bounds, there are too many or too few values, or no
                positions reach the pose.
        """
        if isinstance(arg1, Pose | PoseStamped):
            self._set_target_by_pose(arg1, arg2, arg3)
        elif isinstance(arg1, str):
            if arg2 is None:
                raise MoveItCommanderException("Joint value expected when joint name specified")
            if arg3 is not None:
                raise MoveItCommanderException("Too many arguments specified")
            if isinstance(arg2, list):
                values = doubles(arg2)
            else:
                check_arguments("set_joint_value_target", (arg1, "std::string"), (arg2, "double"))
                values = [arg2]
            if len(values) != 1:
                raise MoveItCommanderException(f"{_OUT_OF_BOUNDS} '{arg1}' has one value")
            self._set_joints({arg1: values[0]})
        elif arg2 is not None or arg3 is not None:
            raise MoveItCommanderException("Too many arguments specified")
        elif isinstance(arg1, JointState):
            if len(arg1.name) != len(arg1.position):
                raise MoveItCommanderException(
                    f"{_OUT_OF_BOUNDS} sizes of name and position arrays do not match"
                )
            self._set_joints(dict(zip(arg1.name, arg1.position, strict=True)))
        elif isinstance(arg1, Mapping):
            self._set_joints(dict(zip(arg1, doubles(arg1.values()), strict=True)))
        elif isinstance(arg1, Iterable):
            self._set_joints(self._named_values(doubles(arg1)))
        else:
            raise MoveItCommanderException(f"Unsupported argument of type {type(arg1)}")

    def set_random_target(self) -> None:
        """Set joint positions drawn evenly within the limits as the target."""
        self._set_joints(self._server.random_target(self._name))

    def _named_values(self, values: Sequence[float]) -> dict[str, float]:
        named = self._server.values_by_name(self._name, values)
        if named is None:
            names = self._server.variables(self._name)
            raise MoveItCommanderException(
                f"{_OUT_OF_BOUNDS} {len(values)} values given, group '{self._name}' has "
                f"{len(names)} joints: {', '.join(names)}"
            )
        return named

    def _set_joints(self, values: Mapping[str, Any]) -> None:
        known = {*self._joint_target, *self._server.variables(self._name)}
        for name in values:
            if name not in known:
                raise MoveItCommanderException(
                    f"{_OUT_OF_BOUNDS} joint '{name}' is not part of group '{self._name}'; "
                    f"{one_of(self._joint_target, name)}"
                )
        # As in MoveIt the target is taken over even where it is then refused.
        self._target_kind = "joint"
        # A value of a joint that follows another one leads nowhere.
        active = self._server.active_joints(self._name)
        given = {name: float(value) for name, value in values.items() if name in active}
        led = self._server.robot.with_followers(given)
        self._joint_target.update({n: value for n, value in led.items() if n in self._joint_target})
        for name in given:
            joint, value = self._server.robot.joint(name), self._joint_target[name]
            slack = self._joint_tolerance
            if not joint.lower - slack <= value <= joint.upper + slack:
                if math.isfinite(value) and self._is_assumed_finger(name):
                    self._joint_target[name] = self._to_assumed_end(joint, value)
                    continue
                raise MoveItCommanderException(
                    f"{_OUT_OF_BOUNDS} {value:g} for joint '{name}' is outside "
                    f"{shown_limits(joint, value)}"
                )

    def _is_assumed_finger(self, name: str) -> bool:
        """Return whether a joint is of the generic arm's gripper, whose range nobody knows."""
        robot = self._server.robot
        fingers = {finger for gripper in robot.grippers for finger in gripper.joints}
        return robot.name == NAME and name in fingers

    def _to_assumed_end(self, joint: Joint, value: float) -> float:
        """Return the end of an assumed range to which a finger goes instead, and say so."""
        end = min(max(value, joint.lower), joint.upper)
        self._server.execution.report(
            "assumed_name",
            f"joint '{joint.name}' of the generic gripper goes to {end:g} instead of {value:g}: "
            "its range is assumed; name the robot with --robot",
            object_name=joint.name,
        )
        return end

    def _set_target_by_pose(self, pose: Any, arg2: Any, arg3: Any) -> None:
        link, approximate = self._end_effector_link, False
        for argument in (arg2, arg3):
            if isinstance(argument, str):
                link = argument or link
            elif isinstance(argument, bool):
                approximate = argument
            elif argument is not None:
                raise MoveItCommanderException("Unexpected type")
        self._target_kind = "joint"
        place: tuple[float, ...] = ()
        try:
            goal = self._pose_goal(link, self._framed(pose, link), "pose")
            place = goal.pose.position
            self._joint_target.update(self._server.reach(self._name, [goal], self._start()))
            self._server.execution.succeeded("planning_failure", self._name, place)
        except PlanningError as error:
            text = f"inverse kinematics of group '{self._name}' failed: {error.message}"
            self._server.execution.report(
                "planning_failure", text, object_name=self._name, target=place
            )
            asked = "support approximate IK?" if approximate else "functional?"
            solver = "Does your IK solver" if approximate else "Is the IK solver"
            raise MoveItCommanderException(
                f"Error setting joint target. {solver} {asked} {error.message}"
            ) from error

    # Named and remembered positions

    def get_named_targets(self) -> list[str]:
        """Return the names of the group's states, the remembered ones first."""
        return [*sorted(self._remembered), *self._server.robot.named_states.get(self._name, {})]

    def set_named_target(self, name: str) -> None:
        """Set a remembered or a named state as the target.

        Raises:
            ArgumentError: it is no string.
            MoveItCommanderException: there is no such state; lists those there are.
        """
        check_arguments("set_named_target", (name, "std::string"))
        if name in self._remembered:
            self._set_joints(self._named_values(self._remembered[name]))
            return
        states = self._server.robot.named_states.get(self._name, {})
        if name not in states:
            raise MoveItCommanderException(
                f"Unable to set target {name}. Is the target within bounds? Group "
                f"'{self._name}' has no named target '{name}'; "
                f"{one_of(self.get_named_targets(), name)}"
            )
        self._set_joints(states[name])

    def get_named_target_values(self, target: str) -> dict[str, float]:
        """Return the joint positions of a remembered or a named state; empty for no state."""
        if target in self._remembered:
            return self._named_values(self._remembered[target])
        return dict(self._server.robot.named_states.get(self._name, {}).get(target, {}))

    def remember_joint_values(self, name: str, values: Sequence[float] | None = None) -> None:
        """Remember joint positions (the present ones) under a name.

        Raises:
            ArgumentError: the positions are no list, or the name is no string.
        """
        chosen = self.get_current_joint_values() if values is None else values
        check_arguments(
            "remember_joint_values", (name, "std::string"), (chosen, "boost::python::list")
        )
        self._remembered[name] = doubles(chosen)

    def get_remembered_joint_values(self) -> dict[str, list[float]]:
        """Return the remembered joint positions by name."""
        return {name: list(self._remembered[name]) for name in sorted(self._remembered)}

    def forget_joint_values(self, name: str) -> None:
        """Forget joint positions."""
        self._remembered.pop(name, None)

    # Poses

    def set_pose_target(self, pose: Any, end_effector_link: str = "") -> None:
        """Set a pose of a link as the target: a Pose, a PoseStamped or a list of 6 or 7 numbers.

        Raises:
            ArgumentError: it is of another type, a tuple or an array.
            MoveItCommanderException: it has another number of values, or there is no link.
        """
        link = self._link(end_effector_link, "set the pose for")
        if not isinstance(pose, Pose | PoseStamped):
            check_arguments("set_pose_target", (pose, "boost::python::list"))
            if len(doubles(pose)) not in (6, 7):
                raise MoveItCommanderException(
                    "Unable to set target pose: Pose description expected to consist of either 6 "
                    "or 7 values"
                )
        self._set_poses([pose], link)

    def set_pose_targets(self, poses: Sequence[Any], end_effector_link: str = "") -> None:
        """Set several poses, of which any will do, as the target.

        Each is a Pose or a list of 6 or 7 numbers; one of another length is left out.

        Raises:
            TypeError: one of them is of another type, a PoseStamped.
            MoveItCommanderException: none is left, or there is no link.
        """
        link = self._link(end_effector_link, "set poses for")
        for pose in poses:
            if not isinstance(pose, Pose | list):
                raise TypeError(
                    "Expecting an object of type list; got an object of type "
                    f"{type(pose).__name__} instead"
                )
        kept = [one for one in poses if isinstance(one, Pose) or len(doubles(one)) in (6, 7)]
        if not kept:
            raise MoveItCommanderException("Unable to set target poses: no pose is in the list")
        self._set_poses(kept, link)

    def _set_poses(self, poses: Sequence[Any], link: str) -> None:
        self._target_kind = "pose"
        self._pose_targets[link] = [self._framed(pose, link, goal_quaternion) for pose in poses]

    def set_position_target(self, xyz: Sequence[float], end_effector_link: str = "") -> None:
        """Set a position of a link [m] as the target; any orientation will do."""
        old = self._known_pose(end_effector_link)
        x, y, z = doubles([xyz[0], xyz[1], xyz[2]])
        self._set_part("position", motion.Pose((x, y, z), old.orientation), end_effector_link)

    def set_orientation_target(self, q: Sequence[float], end_effector_link: str = "") -> None:
        """Set an orientation (x, y, z, w) of a link as the target; any position will do."""
        old = self._known_pose(end_effector_link)
        if len(q) != 4:
            raise MoveItCommanderException("Expected [qx, qy, qz, qw]")
        pose = motion.Pose(old.position, goal_quaternion(doubles(q)))
        self._set_part("orientation", pose, end_effector_link)

    def set_rpy_target(self, rpy: Sequence[float], end_effector_link: str = "") -> None:
        """Set roll, pitch and yaw of a link [rad] as the target; any position will do."""
        old = self._known_pose(end_effector_link)
        if len(rpy) != 3:
            raise MoveItCommanderException("Expected [roll, pitch, yaw]")
        look_at_euler(doubles(rpy), "set_rpy_target")
        pose = motion.Pose(old.position, quaternion_from_rpy(*doubles(rpy)))
        self._set_part("orientation", pose, end_effector_link)

    def shift_pose_target(self, axis: int, value: float, end_effector_link: str = "") -> None:
        """Set the present pose, moved along an axis (0 to 5: x, y, z, roll, pitch, yaw)."""
        here = self._link_pose(end_effector_link, "set poses for")
        if not 0 <= axis < 6:
            raise MoveItCommanderException("An axis value between 0 and 5 expected")
        turn = here.orientation if axis < 3 else rpy_from_quaternion(here.orientation)
        values = [*here.position, *turn]
        values[axis] += value
        self.set_pose_target(values, end_effector_link)

    def clear_pose_target(self, end_effector_link: str) -> None:
        """Forget the pose target of a link."""
        self._pose_targets.pop(end_effector_link, None)

    def clear_pose_targets(self) -> None:
        """Forget all pose targets."""
        self._pose_targets.clear()

    def _known_pose(self, end_effector_link: str) -> motion.Pose:
        link = self._link(end_effector_link, "set the pose for")
        known = self._pose_targets.get(link)
        return known[0].pose if known else conversions._twin_pose([0.0] * 7)

    def _set_part(self, kind: GoalKind, pose: motion.Pose, end_effector_link: str) -> None:
        link = self._link(end_effector_link, "set the pose for")
        self._target_kind = kind
        self._pose_targets[link] = [_FramedPose(self._reference_frame, pose)]

    def _framed(
        self,
        pose: Any,
        link: str,
        turned: Callable[[Sequence[float]], Quaternion] = unit_quaternion,
    ) -> _FramedPose:
        frame = self._reference_frame
        if isinstance(pose, PoseStamped):
            frame, pose = pose.header.frame_id, pose.pose
        values = conversions.pose_to_list(pose) if isinstance(pose, Pose) else pose
        if len(values) == 6:
            look_at_euler(doubles(values)[3:], "a pose of six numbers")
        elif turned is goal_quaternion:
            current().client(ReadPoses).look_at_length(doubles(values)[3:])
        framed = _FramedPose(frame, conversions._twin_pose(values, turned))
        current().client(ReadPoses).given(frame, framed.pose, link, self._server.known_frame)
        return framed

    def _pose_goal(self, link: str, framed: _FramedPose, kind: GoalKind) -> PoseGoal:
        return self._goal(link, compose(self._frame(framed.frame), framed.pose), kind)

    def _frame(self, name: str) -> motion.Pose:
        frame = self._server.frame(name)
        if frame is None:
            links = self._server.robot.link_names
            raise PlanningError("bad_request", f"unknown frame '{name}'; {one_of(links, name)}")
        return frame

    def _goal(self, link: str, pose: motion.Pose, kind: GoalKind = "pose") -> PoseGoal:
        """Return a goal in the planning frame, with the tolerances that are set."""
        return PoseGoal(
            link=link,
            pose=pose,
            kind=kind,
            position_tolerance=self._position_tolerance,
            orientation_tolerance=self._orientation_tolerance,
        )

    def _pose_goals(self, kind: GoalKind) -> list[list[PoseGoal]]:
        """Return the alternatives, each with one goal a link."""
        count = max((len(poses) for poses in self._pose_targets.values()), default=0)
        return [
            [
                self._pose_goal(link, poses[index], kind)
                for link, poses in self._pose_targets.items()
                if index < len(poses)
            ]
            for index in range(count)
        ]
