"""The moves of a Niryo arm: planned as its commander does, in [m] and [rad].

Source: NiryoRobotics/ned_ros, niryo_robot_arm_commander (arm_commander.py, msg/ArmMoveCommand.msg)
and niryo_robot_tools_commander (config/*/tools_definition.yaml).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.robot.trajectory_messages import TrajectoryRefusedError, twin_trajectory
from tracerisk.ros.transforms.poses import (
    ORIGIN,
    compose,
    inverse,
    quaternion_from_rpy,
    rpy_from_quaternion,
)
from tracerisk.twin.motion.plausible_units import cut_line
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose
from tracerisk.twin.robots.robot_parts import Scaling

(JOINTS, POSE, POSITION, RPY, POSE_QUAT, LINEAR_POSE, SHIFT_POSE, SHIFT_LINEAR_POSE) = range(8)
EXECUTE_TRAJ, DRAW_SPIRAL, DRAW_CIRCLE, EXECUTE_FULL_TRAJ, EXECUTE_RAW_TRAJ = range(8, 13)

_GRIPPER_LENGTH = 0.085  # [m]: gripper 1, `transformation` of tools_definition.yaml
_LEAST_RADIUS = 0.003  # of a spiral
_CIRCLE_STEP = 3  # [degrees]


class NiryoMotion:
    """Makes trajectories of an ArmMoveCommand, at the share of the speed that is set."""

    def __init__(self, arm: ArmMotion) -> None:
        self._arm = arm
        self.velocity = 1.0
        self.acceleration = 1.0
        self.is_tcp_on = False
        self.tcp = self.tcp_of_tool()

    def tcp_of_tool(self) -> Pose:
        """Return where the tool that is mounted works, as seen from the tool link."""
        gripper = self._arm.gripper
        if gripper is None or not gripper.pads:
            return ORIGIN
        # The axis of the tool link that leads to the fingers is not the same on all arms.
        back = inverse(self._arm.tool_pose())
        pads = [compose(back, self._arm.twin.link_pose(link)).position for link in gripper.pads]
        middle = np.mean(pads, axis=0)
        axis = int(np.argmax(np.abs(middle)))
        shift = [0.0, 0.0, 0.0]
        shift[axis] = math.copysign(_GRIPPER_LENGTH, middle[axis])
        return Pose((shift[0], shift[1], shift[2]), ORIGIN.orientation)

    @property
    def offset(self) -> Pose:
        """Where the point that poses speak of is, as seen from the tool link."""
        return self.tcp if self.is_tcp_on else ORIGIN

    def here(self) -> Pose:
        """Return the pose that the arm has."""
        return compose(self._arm.tool_pose(), self.offset)

    def of_joints(self, positions: Sequence[float]) -> Pose:
        """Return the pose that joint positions lead to."""
        return compose(self._arm.pose_at(positions), self.offset)

    def to_joints_of(self, pose: Pose) -> list[float]:
        """Return joint positions that lead to a pose."""
        return self._arm.reach(self._of_link(pose))

    def trajectory(self, asked: Any, now_ns: int) -> JointTrajectory | None:
        """Return the way of a command, None where the arm is there already.

        Raises:
            PlanningError: there is none, or the command is malformed.
        """
        kind = asked.cmd_type
        if kind == JOINTS:
            return self._to_joints(list(asked.joints))
        if kind in (POSE, POSITION, RPY, POSE_QUAT):
            return self._to_pose(self._asked(asked))
        if kind == LINEAR_POSE:
            return self._through([self._asked(asked)])
        if kind in (SHIFT_POSE, SHIFT_LINEAR_POSE):
            shifted = self.shifted(asked.shift.axis_number, asked.shift.value)
            return self._to_pose(shifted) if kind == SHIFT_POSE else self._through([shifted])
        if kind == EXECUTE_TRAJ:
            return self.poses([pose_of(list_pose) for list_pose in asked.list_poses])
        if kind == DRAW_SPIRAL:
            return self._through(self._spiral(asked.args))
        if kind == DRAW_CIRCLE:
            return self._through(self._circle(asked.position))
        if kind in (EXECUTE_FULL_TRAJ, EXECUTE_RAW_TRAJ):
            try:
                return twin_trajectory(asked.trajectory, self._arm.twin, now_ns)
            except TrajectoryRefusedError as error:
                raise PlanningError("invalid_goal", str(error)) from error
        raise PlanningError("bad_request", f"cmd_type {kind}; allowed: 0 to 12")

    def shifted(self, axis: int, value: float) -> Pose:
        """Return the present pose with one of x, y, z, roll, pitch, yaw changed."""
        here = self.here()
        values = [*here.position, *rpy_from_quaternion(here.orientation)]
        if not 0 <= axis < len(values):
            raise PlanningError("invalid_goal", f"axis_number {axis}; allowed: 0 to 5")
        values[axis] += value
        x, y, z, roll, pitch, yaw = values
        return Pose((x, y, z), quaternion_from_rpy(roll, pitch, yaw))

    def poses(self, poses: Sequence[Pose]) -> JointTrajectory:
        """Return the way through poses: in straight lines where that can be, else as it can."""
        if not poses:
            raise PlanningError("no_plan", "a list of 0 poses")
        try:
            whole = self._through(poses)
        except PlanningError:
            whole = None
        if whole is not None:
            return whole
        parts: list[JointTrajectory] = []
        start: dict[str, float] = {}
        for pose in poses:
            try:
                part = self._through([pose], start)
            except PlanningError:
                part = self._to_pose(pose, start)
            if part is not None:
                parts.append(part)
                start = dict(zip(part.joints, part.position[-1].tolist(), strict=True))
        if not parts:
            raise PlanningError("no_plan", "the arm is at all of the poses")
        return _joined(parts)

    # How it is done

    def _of_link(self, pose: Pose) -> Pose:
        return compose(pose, inverse(self.offset))

    def _asked(self, asked: Any) -> Pose:
        here = self.here()
        at = (asked.position.x, asked.position.y, asked.position.z)
        turned = quaternion_from_rpy(asked.rpy.roll, asked.rpy.pitch, asked.rpy.yaw)
        if asked.cmd_type == POSITION:
            # Any orientation would do: the present one does.
            return Pose(at, here.orientation)
        if asked.cmd_type == RPY:
            return Pose(here.position, turned)
        if asked.cmd_type == POSE_QUAT:
            turn = asked.orientation
            return Pose(at, (turn.x, turn.y, turn.z, turn.w))
        return Pose(at, turned)

    def _group(self) -> str:
        if self._arm.group is None:
            raise PlanningError("bad_request", "the robot has no planning group with a tip link")
        return self._arm.group

    def _to_joints(self, goal: Sequence[float]) -> JointTrajectory:
        self._arm.check(goal)
        target = dict(zip(self._arm.joints, goal, strict=True))
        return self._arm.twin.plan_joints(
            self._group(),
            target,
            scaling=Scaling(self.velocity, self.acceleration),
        )

    def _to_pose(self, pose: Pose, start: dict[str, float] | None = None) -> JointTrajectory:
        return self._arm.twin.plan_pose(
            self._group(),
            self._of_link(pose),
            link=self._arm.tool,
            start=start,
            scaling=Scaling(self.velocity, self.acceleration),
        )

    def _through(
        self, poses: Sequence[Pose], start: dict[str, float] | None = None
    ) -> JointTrajectory | None:
        joint_trajectory, fraction = self._arm.twin.plan_cartesian(
            self._group(),
            [self._of_link(pose) for pose in poses],
            link=self._arm.tool,
            start=start,
            scaling=Scaling(self.velocity, self.acceleration),
        )
        if fraction < 1.0 - 1e-6:
            raise PlanningError("no_plan", cut_line(poses[-1], fraction, self._arm.tool_pose()))
        return joint_trajectory if len(joint_trajectory.time) > 1 else None

    def _spiral(self, values: Sequence[float]) -> list[Pose]:
        if len(values) != 4 or values[3] not in (1, 2, 3):
            raise PlanningError(
                "invalid_goal",
                f"args {list(values)}; a spiral has radius, angle step, number of steps and plane "
                "(1 yz, 2 xz, 3 xy)",
            )
        radius, step, count, plane = values
        first, second = {1: (1, 2), 2: (0, 2), 3: (0, 1)}[int(plane)]
        here, angle, spiral = self.here(), 0.0, []
        outward = np.linspace(0.0, radius, num=int(count))
        for distance in (*outward, *(radius - outward)):
            position = list(here.position)
            position[first] += (distance + _LEAST_RADIUS) * math.cos(angle)
            position[second] += (distance + _LEAST_RADIUS) * math.sin(angle)
            spiral.append(Pose((position[0], position[1], position[2]), here.orientation))
            angle += math.radians(step)
        return spiral

    def _circle(self, centre: Any) -> list[Pose]:
        here = self.here()
        x, y, z = here.position
        radius = math.dist(here.position, (centre.x, centre.y, centre.z))
        begin = math.atan2(z - centre.z, y - centre.y)
        turned = (math.radians(index) for index in range(0, 360 + _CIRCLE_STEP, _CIRCLE_STEP))
        return [
            Pose(
                (
                    x,
                    centre.y + radius * math.cos(begin - angle),
                    centre.z + radius * math.sin(begin - angle),
                ),
                here.orientation,
            )
            for angle in turned
        ]


def pose_of(message: Any) -> Pose:
    """Return the pose of a message geometry_msgs/Pose."""
    at, turn = message.position, message.orientation
    return Pose((at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w))


def _joined(parts: Sequence[JointTrajectory]) -> JointTrajectory:
    """Return trajectories one after the other; each begins where the one before rests."""
    times, positions, velocities, now = [], [], [], 0.0
    for number, part in enumerate(parts):
        first = 1 if number else 0
        times.append(part.time[first:] + now)
        positions.append(part.position[first:])
        velocities.append(part.velocity[first:])
        now += part.duration_s
    return JointTrajectory(
        parts[0].joints, np.concatenate(times), np.vstack(positions), np.vstack(velocities)
    )
