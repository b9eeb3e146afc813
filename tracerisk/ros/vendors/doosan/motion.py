"""What a Doosan arm's commands move: [deg], [mm], and turns about z, y', z'' (Euler ZYZ).

Source: DoosanRobotics/doosan-robot2, dsr_msgs2/srv/motion and dsr_common2/imp/DSR_ROBOT2.py; the
programming manual (DRL) for frames and solution spaces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tracerisk.ros.robot.arm_motion import ArmMotion
from tracerisk.ros.transforms.poses import (
    ORIGIN,
    Quaternion,
    Vector,
    compose,
    inverse,
    multiply,
    rotate,
    shifted,
)
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

BASE, TOOL, WORLD = 0, 1, 2
ABSOLUTE, RELATIVE = 0, 1

_ARC_STEPS = 24
_PERIOD_STEPS = 40  # points in the shortest period


class DoosanMotion:
    """Makes trajectories; `tcp` is the tool centre point as seen from the flange."""

    def __init__(self, arm: ArmMotion) -> None:
        self.arm = arm
        self.tcp = ORIGIN
        self.share = 1.0  # of the speeds that are asked for

    def here(self) -> Pose:
        """Return where the tool centre point is."""
        return compose(self.arm.tool_pose(), self.tcp)

    def positions(self) -> list[float]:
        """Return where the joints are [deg]."""
        return [math.degrees(position) for position in self.arm.positions()]

    def of_joints(self, degrees: Sequence[float]) -> Pose:
        """Return where the tool centre point is at joint positions [deg]."""
        return compose(self.arm.pose_at([math.radians(degree) for degree in degrees]), self.tcp)

    def to_joints_of(self, pose: Pose) -> list[float]:
        """Return joint positions [deg] that lead to a pose; PlanningError where there are none."""
        reach = self.arm.reach(compose(pose, inverse(self.tcp)))
        return [math.degrees(value) for value in reach]

    def pose(
        self, values: Sequence[float], ref: int, mode: int, before: Pose | None = None
    ) -> Pose:
        """Return the pose in the base frame that six values mean.

        `before` is where the way has led so far, by default where the arm is.
        """
        here, asked = before or self.here(), pose_of(values)
        if ref not in (BASE, TOOL, WORLD):
            raise PlanningError(
                "bad_request",
                f"reference {ref} is not simulated; allowed: 0 (base), 1 (tool), 2 (world)",
            )
        if ref == TOOL:
            return compose(here, asked)
        if mode == RELATIVE:
            return shifted(here, asked)
        return asked

    def joint_move(
        self,
        degrees: Sequence[float],
        mode: int,
        speeds: Sequence[float],
        rises: Sequence[float],
        time_s: float,
    ) -> JointTrajectory:
        """Return the move of all joints to [deg], at [deg/s] and [deg/s^2] or in a time [s]."""
        goal = list(degrees[: len(self.arm.joints)])
        if mode == RELATIVE:
            goal = [a + b for a, b in zip(goal, self.positions(), strict=True)]
        radians = [math.radians(value) for value in goal]
        if time_s > 0.0:
            return self.arm.to_joints(radians, duration_s=time_s / self.share)
        if min(speeds) <= 0.0 or min(rises) <= 0.0:
            raise PlanningError(
                "bad_request",
                f"velocity {min(speeds):g} and acceleration {min(rises):g}; both, or a time, must "
                "be above 0",
            )
        return self.arm.to_joints(
            radians,
            speeds=[math.radians(speed) * self.share for speed in speeds],
            rises=[math.radians(rise) for rise in rises],
        )

    def spline(
        self,
        points: Sequence[Sequence[float]],
        mode: int,
        speeds: Sequence[float],
        rises: Sequence[float],
        time_s: float,
    ) -> JointTrajectory:
        """Return the way through joint positions [deg], at rest at its end only."""
        goals: list[list[float]] = []
        here = self.positions()
        for point in points:
            here = [a + b for a, b in zip(here, point, strict=False)] if mode else list(point)
            goals.append(here)
        if not goals:
            raise PlanningError("bad_request", "a spline of 0 points")
        radians = [[math.radians(value) for value in goal] for goal in goals]
        limits = (
            [math.radians(speed) * self.share for speed in speeds] if min(speeds) > 0 else None,
            [math.radians(rise) for rise in rises] if min(rises) > 0 else None,
        )
        if time_s <= 0.0 and None in limits:
            raise PlanningError(
                "bad_request", "velocity and acceleration, or a time, must be above 0"
            )
        times, now, before = [], 0.0, self.arm.positions()
        for goal in radians:
            now += self.arm.fastest_s(before, goal, *(limits if time_s <= 0 else (None, None)))
            times.append(now)
            before = goal
        slower = max(1.0, time_s / now) if time_s > 0 else 1.0
        return self.arm.through(radians, [time * slower for time in times])

    def line(
        self, poses: Sequence[Pose], speeds: Sequence[float], time_s: float
    ) -> JointTrajectory:
        """Return the way of the tool in straight lines, at [mm/s, deg/s] or in a time [s]."""
        if not poses:
            raise PlanningError("bad_request", "a way of 0 poses")
        flange = [compose(pose, inverse(self.tcp)) for pose in poses]
        if time_s > 0.0:
            return self.arm.line(flange, duration_s=time_s / self.share)
        speed, turn = [*speeds, 0.0][:2]
        if speed <= 0.0:
            raise PlanningError(
                "bad_request", f"velocity {speed:g} mm/s; it, or a time, must be above 0"
            )
        # A turn that is not given keeps to the joints' own speeds.
        radians = math.radians(turn) * self.share if turn > 0.0 else math.inf
        return self.arm.line(flange, speed=speed / 1000 * self.share, turn=radians)

    def arc(self, via: Pose, end: Pose, before: Pose | None = None) -> list[Pose]:
        """Return poses along the circle from where the tool is through `via` to `end`.

        Raises:
            PlanningError: the three lie on a line.
        """
        start = before or self.here()
        a, b, c = (np.array(pose.position) for pose in (start, via, end))
        normal = np.cross(b - a, c - a)
        area = float(np.dot(normal, normal))
        if area < 1e-14:
            raise PlanningError("invalid_goal", "the three points of the circle lie on a line")
        to_b, to_c = b - a, c - a
        centre = a + (
            np.cross(normal, to_b) * np.dot(to_c, to_c)
            + np.cross(to_c, normal) * np.dot(to_b, to_b)
        ) / (2 * area)
        axis = normal / math.sqrt(area)
        u = a - centre
        v = np.cross(axis, u)
        swept = math.atan2(float(np.dot(c - centre, v)), float(np.dot(c - centre, u))) % math.tau
        poses = []
        for share in np.linspace(0.0, 1.0, _ARC_STEPS + 1)[1:]:
            angle = swept * share
            x, y, z = (float(item) for item in centre + u * math.cos(angle) + v * math.sin(angle))
            poses.append(Pose((x, y, z), _between(start.orientation, end.orientation, share)))
        return poses

    def spiral(self, turns: float, radius: float, length: float, axis: int, ref: int) -> list[Pose]:
        """Return poses along a spiral [m] about the axis x, y or z (0 to 2) of the base or tool."""
        here, poses = self.here(), []
        if axis not in (0, 1, 2):
            raise PlanningError("bad_request", f"task axis {axis}; allowed: 0, 1, 2")
        first, second = (axis + 1) % 3, (axis + 2) % 3
        count = max(8, round(_ARC_STEPS * turns))
        for share in np.linspace(0.0, 1.0, count + 1)[1:]:
            shift = [0.0, 0.0, 0.0]
            shift[first] = radius * share * math.cos(math.tau * turns * share)
            shift[second] = radius * share * math.sin(math.tau * turns * share)
            shift[axis] = length * share
            way = rotate(here.orientation, shift) if ref == TOOL else shift
            x, y, z = (a + b for a, b in zip(here.position, way, strict=True))
            poses.append(Pose((x, y, z), here.orientation))
        return poses

    def periodic(
        self, amplitudes: Sequence[float], periods: Sequence[float], repeat: int, ref: int
    ) -> JointTrajectory:
        """Return sines of the tool: amplitudes [mm, deg], periods [s]; the longest is repeated."""
        moving = [p for a, p in zip(amplitudes, periods, strict=True) if a and p > 0.0]
        if not moving or repeat < 1:
            raise PlanningError(
                "bad_request", "no axis has an amplitude, a period and a repetition"
            )
        here, total = self.here(), max(moving) * repeat
        count = max(8, math.ceil(total / min(moving) * _PERIOD_STEPS))
        points: list[list[float]] = []
        times = [float(item) for item in np.linspace(0.0, total, count + 1)[1:]]
        seed = self.arm.positions()
        for time in times:
            ease = math.sin(
                min(time, total - time, min(moving) / 4) / (min(moving) / 4) * math.pi / 2
            )
            values = [
                ease * a * math.sin(math.tau * time / p) if a and p > 0.0 else 0.0
                for a, p in zip(amplitudes, periods, strict=True)
            ]
            pose = self.pose(values, TOOL if ref == TOOL else BASE, RELATIVE, here)
            seed = self.arm.reach(compose(pose, inverse(self.tcp)), seed)
            points.append(seed)
        return self.arm.through(points, times)

    def solution_space(self) -> int:
        """Return 0 to 7: shoulder right (4), elbow above (2), wrist flipped (1)."""
        joints = self.arm.positions()
        x, y, _ = self.arm.tool_pose().position
        forward = x * math.cos(joints[0]) + y * math.sin(joints[0])
        return 4 * (forward < 0.0) + 2 * (joints[2] >= 0.0) + (joints[4] < 0.0)


def pose_of(values: Sequence[float]) -> Pose:
    """Return the pose of x, y, z [mm], and turns about z, y', z'' [deg]."""
    x, y, z, a, b, c = (float(value) for value in values[:6])
    turn = multiply(multiply(_about(2, a), _about(1, b)), _about(2, c))
    return Pose((x / 1000, y / 1000, z / 1000), turn)


def values_of(pose: Pose) -> list[float]:
    """Return x, y, z [mm], and turns about z, y', z'' [deg] of a pose."""
    columns = [rotate(pose.orientation, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    (r11, r21, r31), (_, _, r32), (r13, r23, r33) = columns
    b = math.atan2(math.hypot(r13, r23), r33)
    if math.sin(b) > 1e-6:
        a, c = math.atan2(r23, r13), math.atan2(r32, -r31)
    else:
        # Only the sum or the difference of both turns about z is defined here.
        a, c = (math.atan2(r21, r11) if r33 > 0 else math.atan2(-r21, -r11)), 0.0
    return [*(1000 * value for value in pose.position), *(math.degrees(v) for v in (a, b, c))]


def rows_of(pose: Pose) -> list[Vector]:
    """Return the rotation matrix of a pose, row by row."""
    columns = [rotate(pose.orientation, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return [(columns[0][i], columns[1][i], columns[2][i]) for i in range(3)]


def _about(axis: int, degrees: float) -> Quaternion:
    half = math.radians(degrees) / 2
    parts = [0.0, 0.0, 0.0]
    parts[axis] = math.sin(half)
    return (parts[0], parts[1], parts[2], math.cos(half))


def _between(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """Return the turn a share of the way from `a` to `b`, at constant speed (slerp)."""
    first, second = np.array(a), np.array(b)
    cosine = float(np.dot(first, second))
    if cosine < 0.0:
        second, cosine = -second, -cosine
    angle = math.acos(min(cosine, 1.0))
    if angle < 1e-9:
        return a
    mixed = math.sin((1 - share) * angle) * first + math.sin(share * angle) * second
    x, y, z, w = (float(item) for item in mixed / math.sin(angle))
    return (x, y, z, w)
