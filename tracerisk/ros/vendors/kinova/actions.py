"""What the actions of a Kinova arm move: angles in degrees, poses in metres and degrees.

Source: Kinovarobotics/ros_kortex, kortex_driver (msg/generated/base, and the behaviour of
kortex_arm_simulation.cpp, its own simulated driver); angles of continuous joints go the short way
round.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tracerisk.ros.robot.arm_motion import ArmMotion, TwistFrame
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.transforms.poses import ORIGIN, compose, quaternion_from_rpy, rpy_from_quaternion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

MIXED, TOOL, BASE = 1, 2, 3
"""Frames of reference: translations in the base and turns in the tool, both in the tool, or both
in the base."""
_TWISTS: Mapping[int, TwistFrame] = {MIXED: "mixed", TOOL: "tool"}
BY_DURATION, BY_SPEED = 1, 2
SPEED, POSITION = 2, 3
"""Modes of the gripper: a speed, whose sign opens or closes, and a position (0 open, 1 closed)."""

_COUNT_MISMATCH, _INVALID_DURATION, _JOINT_LIMIT = 2, 3, 11
_NO_SUCH_PLACE, _SEVERAL_TYPES, _NO_SUCH_FRAME = 20, 25, 29
_UNAPPLICABLE, _TIME, _AT = 1, 2, 3


@dataclass(frozen=True, slots=True)
class WaypointError:
    """Why a list of waypoints cannot be followed: the fields of TrajectoryErrorElement."""

    type: int
    """The type of the error, as Kortex numbers it."""
    identifier: int
    """The identifier of the error, as Kortex numbers it."""
    message: str
    """The error in words."""
    waypoint: int = 0
    """The index of the waypoint, from 0."""
    joint: int = 0
    """The index of the joint, from 0."""
    value: float = 0.0
    """The value that is not allowed [deg or s]."""
    least: float = 0.0
    """The least allowed value [deg or s]."""
    most: float = 0.0
    """The greatest allowed value [deg or s]."""


class KortexArm:
    """Makes trajectories of what messages of kortex_driver ask for."""

    def __init__(self, arm: ArmMotion) -> None:
        self.arm = arm

    # Units

    def angles(self) -> list[float]:
        """Return where the joints are, in [0, 360) degrees."""
        return [math.degrees(position) % 360.0 for position in self.arm.positions()]

    def goal(self, degrees: Sequence[float], here: Sequence[float] | None = None) -> list[float]:
        """Return the joint positions [rad] that angles in degrees mean."""
        near = self.arm.positions() if here is None else here
        return [
            _near(float(angle), at, joint.lower, joint.upper, joint.type == "continuous")
            for angle, at, joint in zip(degrees, near, self.arm.arm, strict=False)
        ]

    # Trajectories

    def reach_angles(self, asked: Any) -> JointTrajectory:
        """Return the way to ConstrainedJointAngles."""
        here = self.angles()
        for joint_angle in asked.joint_angles.joint_angles:
            _put(here, joint_angle.joint_identifier, joint_angle.value)
        if not asked.joint_angles.joint_angles:
            raise PlanningError("invalid_goal", "no joint angles")
        asked_for = [joint_angle.value for joint_angle in asked.joint_angles.joint_angles]
        self.arm.look_at_degrees("a goal of joint angles", asked_for)
        return self._to_angles(here, asked.constraint)

    def reach_angle(self, asked: Any) -> JointTrajectory:
        """Return the way of one joint to a ConstrainedJointAngle."""
        here = self.angles()
        _put(here, asked.joint_identifier, asked.value)
        return self._to_angles(here, asked.constraint)

    def reach_pose(self, asked: Any) -> JointTrajectory:
        """Return the line to a ConstrainedPose."""
        return self._line_to(pose_of(asked.target_pose), asked.constraint)

    def reach_position(self, asked: Any) -> JointTrajectory:
        """Return the line to a ConstrainedPosition; the tool keeps its orientation."""
        at = asked.target_position
        here = self.arm.tool_pose().orientation
        return self._line_to(Pose((at.x, at.y, at.z), here), asked.constraint)

    def reach_orientation(self, asked: Any) -> JointTrajectory:
        """Return the turn to a ConstrainedOrientation; the tool stays where it is."""
        to = asked.target_orientation
        turned = _turn(to.theta_x, to.theta_y, to.theta_z)
        return self._line_to(Pose(self.arm.tool_pose().position, turned), asked.constraint)

    def joint_speeds(self, asked: Any) -> JointTrajectory | None:
        """Return the way at Base_JointSpeeds [deg/s], None where they stop the arm."""
        speeds = [0.0] * len(self.arm.joints)
        for joint_speed in asked.joint_speeds:
            _put(speeds, joint_speed.joint_identifier, math.radians(joint_speed.value))
        self.arm.look_at_degrees_per_s("joint_velocity", [math.degrees(speed) for speed in speeds])
        return self.arm.at_speeds(speeds, asked.duration / 1000.0 or None)

    def twist(self, asked: Any, frame: int) -> JointTrajectory | None:
        """Return the way at a TwistCommand [m/s, deg/s], None where it stops the arm."""
        twist = asked.twist
        frame = asked.reference_frame or frame
        return self.arm.twist(
            (twist.linear_x, twist.linear_y, twist.linear_z),
            [math.radians(v) for v in (twist.angular_x, twist.angular_y, twist.angular_z)],
            _TWISTS.get(frame, "base"),
            asked.duration / 1000.0 or None,
        )

    # Waypoints

    def waypoints(self, asked: Any) -> JointTrajectory:
        """Return the way through a WaypointList.

        Raises:
            PlanningError: the list is invalid.
        """
        for error in self.errors(asked):
            raise PlanningError("invalid_goal", f"waypoint {error.waypoint}: {error.message}")
        kinds = [waypoint.oneof_type_of_waypoint for waypoint in asked.waypoints]
        if kinds[0].angular_waypoint:
            points, times, here, now = [], [], self.arm.positions(), 0.0
            for kind in kinds:
                here = self.goal(kind.angular_waypoint[0].angles, here)
                now += kind.angular_waypoint[0].duration
                points.append(here)
                times.append(now)
            if len(points) == 1:
                return self.arm.to_joints(points[0], duration_s=times[0])
            return self.arm.through(points, times)
        return self.poses([kind.cartesian_waypoint[0] for kind in kinds], asked.duration)

    def poses(
        self, asked: Sequence[Any], duration_s: float = 0.0, *, in_degrees: bool = True
    ) -> JointTrajectory:
        """Return the line through CartesianWaypoints; corners are not blended."""
        result: list[Pose] = []
        for item in asked:
            frame = result[-1] if result else self.arm.tool_pose()
            pose = pose_of(item.pose, in_degrees=in_degrees)
            if item.reference_frame == TOOL:
                pose = compose(frame, pose)
            elif item.reference_frame == MIXED:
                x, y, z = (a + b for a, b in zip(frame.position, pose.position, strict=True))
                turned = compose(Pose(ORIGIN.position, frame.orientation), pose).orientation
                pose = Pose((x, y, z), turned)
            result.append(pose)
        speeds = [item.maximum_linear_velocity for item in asked if item.maximum_linear_velocity]
        turns = [item.maximum_angular_velocity for item in asked if item.maximum_angular_velocity]
        turn = min(turns, default=math.inf)
        return self.arm.line(
            result,
            speed=min(speeds, default=math.inf),
            turn=math.radians(turn) if in_degrees else turn,
            duration_s=duration_s,
        )

    def errors(self, asked: Any) -> list[WaypointError]:
        """Return what keeps a WaypointList from being followed."""
        kinds = [waypoint.oneof_type_of_waypoint for waypoint in asked.waypoints]
        angular = [bool(kind.angular_waypoint) for kind in kinds]
        empty = [not kind.angular_waypoint and not kind.cartesian_waypoint for kind in kinds]
        if not kinds or any(empty):
            return [WaypointError(_COUNT_MISMATCH, _UNAPPLICABLE, "no waypoint is given")]
        if any(angular) and not all(angular):
            return [WaypointError(_SEVERAL_TYPES, _UNAPPLICABLE, "angular and cartesian waypoints")]
        return list(self._angular(kinds) if angular[0] else self._cartesian(kinds))

    def _angular(self, kinds: Sequence[Any]) -> Iterator[WaypointError]:
        here = self.arm.positions()
        for number, kind in enumerate(kinds):
            waypoint = kind.angular_waypoint[0]
            if len(waypoint.angles) != len(here):
                text = f"{len(waypoint.angles)} angles for {len(here)} joints"
                yield WaypointError(_COUNT_MISMATCH, _UNAPPLICABLE, text, number)
                return
            goal = self.goal(waypoint.angles, here)
            for i, (joint, value) in enumerate(zip(self.arm.arm, goal, strict=True)):
                if not joint.lower - 1e-3 <= value <= joint.upper + 1e-3:
                    at, least, most = (math.degrees(v) for v in (value, joint.lower, joint.upper))
                    text = f"{at:.1f} degrees for '{joint.name}', outside [{least:.1f}, {most:.1f}]"
                    yield WaypointError(_JOINT_LIMIT, _AT, text, number, i, at, least, most)
            soonest = self.arm.fastest_s(here, goal)
            if waypoint.duration < soonest - 1e-6:
                text = f"a duration of {waypoint.duration:g} s; the arm takes {soonest:.2f} s"
                yield WaypointError(
                    _INVALID_DURATION, _TIME, text, number, 0, waypoint.duration, soonest, math.inf
                )
            here = goal

    def _cartesian(self, kinds: Sequence[Any]) -> Iterator[WaypointError]:
        seed = self.arm.positions()
        for number, kind in enumerate(kinds):
            waypoint = kind.cartesian_waypoint[0]
            if waypoint.reference_frame not in (MIXED, TOOL, BASE):
                text = f"reference_frame {waypoint.reference_frame}"
                yield WaypointError(_NO_SUCH_FRAME, _UNAPPLICABLE, text, number)
            elif waypoint.reference_frame == BASE:
                try:
                    seed = self.arm.reach(pose_of(waypoint.pose), seed)
                except PlanningError as error:
                    yield WaypointError(_NO_SUCH_PLACE, _AT, error.message, number)

    # How it is done

    def _to_angles(self, degrees: Sequence[float], constraint: Any) -> JointTrajectory:
        goal = self.goal(degrees)
        if constraint.type == BY_DURATION:
            if constraint.value <= 0.0:
                raise PlanningError("invalid_goal", "a duration is above 0")
            return self.arm.to_joints(goal, duration_s=constraint.value)
        if constraint.type == BY_SPEED:
            if constraint.value <= 0.0:
                raise PlanningError("invalid_goal", "a speed is above 0")
            speeds = [math.radians(constraint.value)] * len(goal)
            return self.arm.to_joints(goal, speeds=speeds)
        return self.arm.to_joints(goal)

    def _line_to(self, pose: Pose, constraint: Any) -> JointTrajectory:
        oneof = constraint.oneof_type
        speed = turn = math.inf
        if oneof.speed:
            speed = oneof.speed[0].translation or math.inf
            turn = math.radians(oneof.speed[0].orientation) or math.inf
        duration_s = float(oneof.duration[0]) if oneof.duration else 0.0
        return self.arm.line([pose], speed=speed, turn=turn, duration_s=duration_s)


def _put(values: list[float], joint: int, value: float) -> None:
    """Set what is asked of one joint by its number; raise PlanningError where there is none."""
    if joint >= len(values):
        raise PlanningError("invalid_goal", f"joint_identifier {joint} of {len(values)} joints")
    values[joint] = value


def pose_of(asked: Any, *, in_degrees: bool = True) -> Pose:
    """Return the pose of a message Pose: [m], and turns about x, y, z in that order."""
    turns = (asked.theta_x, asked.theta_y, asked.theta_z)
    turned = _turn(*turns) if in_degrees else quaternion_from_rpy(*turns)
    return Pose((asked.x, asked.y, asked.z), turned)


def write_pose(message: Any, pose: Pose) -> Any:
    """Fill a message Pose, and return it."""
    message.x, message.y, message.z = pose.position
    turns = [math.degrees(value) for value in rpy_from_quaternion(pose.orientation)]
    message.theta_x, message.theta_y, message.theta_z = turns
    return message


def _turn(x: float, y: float, z: float) -> tuple[float, float, float, float]:
    return quaternion_from_rpy(math.radians(x), math.radians(y), math.radians(z))


def _near(degrees: float, at: float, lower: float, upper: float, is_continuous: bool) -> float:
    """Return the angle [rad], turned by whole turns into the limits and nearest to `at`."""
    angle, turn = math.radians(degrees), 2 * math.pi
    if is_continuous:
        return at + (angle - at + math.pi) % turn - math.pi
    candidates = [angle + k * turn for k in (-1, 0, 1) if lower <= angle + k * turn <= upper]
    wrapped = (angle + math.pi) % turn - math.pi
    return min(candidates, key=lambda candidate: abs(candidate - at), default=wrapped)


def joint_angles(messages: TwinMessages, positions: Sequence[float]) -> list[Any]:
    """Return messages JointAngle of joint positions [rad]."""
    angles = []
    for number, position in enumerate(positions):
        angle = messages.new("kortex_driver/JointAngle")
        angle.joint_identifier, angle.value = number, math.degrees(position) % 360.0
        angles.append(angle)
    return angles
