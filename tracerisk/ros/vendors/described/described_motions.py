"""The motions that a described driver makes of what it is asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from tracerisk.ros.robot.arm_motion import ArmMotion, TwistFrame
from tracerisk.ros.robot.motion_profiles import Ramp, ramp_of_speed, ramped
from tracerisk.ros.robot.trajectory_messages import TrajectoryRefusedError, twin_trajectory
from tracerisk.ros.vendors.answers import Result
from tracerisk.ros.vendors.described.asked_goals import AskedGoals, asked_by
from tracerisk.ros.vendors.description import Case, Driver, Value, is_share
from tracerisk.ros.vendors.requests import Request
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_SAME = 1e-6  # postures of which no joint is further apart are one [rad or m]

Make = Callable[[], JointTrajectory | None]


@dataclass(eq=False)
class DescribedMotions:
    """Makes motions of the arm and of the gripper; numbers are read when the message comes."""

    _driver: Driver
    """The description of the driver."""
    _arm: ArmMotion
    """The arm that moves."""
    _state: Mapping[str, Any]
    """The present values of the driver's state and parameters, by name."""
    _runtime: Runtime
    """The runtime of the run."""
    _goals: AskedGoals = field(init=False)
    """What reads goals of joints and poses from a request."""

    def __post_init__(self) -> None:
        self._goals = AskedGoals(self._driver, self._arm, self._runtime)

    # What is asked for

    def move(self, case: Case, request: Request) -> Make:
        """Return what makes the trajectory of a move at its turn.

        Raises:
            PlanningError: the message is malformed.
        """
        roles = case.roles
        is_line = request.flag(roles.get("line"), default=False)
        is_relative = request.flag(roles.get("relative"), default=False)
        duration_s = request.seconds(roles.get("duration")) or 0.0
        speed = self._rate(request, roles.get("speed"), is_line, "speed_scaling")
        rise = self._rate(request, roles.get("acceleration"), is_line, "acceleration_scaling")
        if "trajectory" in roles:
            return lambda: self._trajectory(request.raw(roles["trajectory"]))
        if "joints" in roles or "named" in roles:
            points = self._goals.joint_goals(roles, request)

            def by_joints() -> JointTrajectory:
                goals = [self._goals.full(point, is_relative=is_relative) for point in points]
                if is_line:
                    return self._line(
                        [self._arm.pose_at(goal) for goal in goals], speed, duration_s
                    )
                return self._through(goals, speed, rise, duration_s)

            return by_joints
        frame = request.word(roles.get("frame"))
        asked = self._goals.asked_poses(roles, request)

        def by_pose() -> JointTrajectory:
            poses = self._goals.poses(asked, frame, is_relative=is_relative)
            if is_line:
                return self._line(poses, speed, duration_s)
            goals: list[Sequence[float]] = []
            for pose in poses:
                goals.append(self._arm.reach(pose, goals[-1] if goals else None))
            return self._through(goals, speed, rise, duration_s)

        return by_pose

    def set_point(
        self, case: Case, request: Request, before: Sequence[float] | None = None
    ) -> dict[str, float] | None:
        """Return where the joints shall be that a message of a stream asks for, None for a way.

        `before` is where the stream leads already, which a step in the tool's axes goes on from.
        """
        if "trajectory" in case.roles or request.flag(case.roles.get("line"), default=False):
            return None
        is_relative = request.flag(case.roles.get("relative"), default=False)
        if "joints" in case.roles or "named" in case.roles:
            (goal, *more) = self._goals.joint_goals(case.roles, request)
            if more:
                return None
            full = self._goals.full(goal, is_relative=is_relative)
        else:
            asked = self._goals.asked_poses(case.roles, request)
            frame = request.word(case.roles.get("frame"))
            at = None if before is None else self._arm.pose_at(before)
            (pose, *_) = self._goals.poses(asked, frame, is_relative=is_relative, here=at)
            full = self._arm.reach(pose, self._arm.positions())
        self._arm.check(full)
        return dict(zip(self._arm.joints, full, strict=True))

    def share(self, case: Case, request: Request) -> float:
        """Return with which share of their rated speed set-points are gone to."""
        kind, rate = self._rate(request, case.roles.get("speed"), False, "speed_scaling")
        if kind == "share":
            return min(max(rate, 1e-3), 1.0)
        if not math.isfinite(rate):
            return 1.0
        fastest = max(joint.velocity_limit for joint in self._arm.arm)
        return min(max(rate / fastest, 1e-3), 1.0)

    def velocity(self, case: Case, request: Request) -> Make:
        """Return what makes the trajectory of a velocity; it makes None where all is at rest."""
        duration_s = request.seconds(case.roles.get("duration"))
        if "twist" in case.roles:
            linear, angular = request.twist(case.roles["twist"])
            in_tool = request.word(case.roles.get("frame")) == "tool"
            frame: TwistFrame = "tool" if in_tool else "base"
            return lambda: self._arm.twist(linear, angular, frame, duration_s)
        speeds = self.speeds(case, request)
        names = [speeds.get(name, 0.0) for name in self._arm.joints]
        return lambda: self._arm.at_speeds(names, duration_s)

    def speeds(self, case: Case, request: Request) -> dict[str, float]:
        """Return the velocities of joints that are asked for [rad/s], by their names."""
        value = case.roles["joints"]
        (goal, *_) = request.goals(value, case.roles.get("joint_names"), "angle")
        if isinstance(goal, Mapping):
            named = goal
        else:
            self._goals._check_count(goal)
            named = dict(zip(self._arm.joints, goal, strict=False))
        named = self._goals.by_joints(named)
        self._goals.check_names(named)
        if self._goals.is_in_degrees(value, request):
            degrees = [math.degrees(named.get(name, 0.0)) for name in self._arm.joints]
            self._arm.look_at_degrees_per_s(asked_by(value), degrees)
        if not is_share(value.unit):
            return dict(named)
        rated = {joint.name: joint.velocity_limit for joint in self._arm.arm}
        return {name: share * rated[name] for name, share in named.items()}

    def grip(self, case: Case, request: Request) -> Callable[[], Motion]:
        """Return what starts a motion of the gripper."""
        roles = case.roles
        gripper = self._arm.gripper
        effort = None
        if roles.get("effort") is not None and gripper is not None:
            effort = request.number(roles["effort"], "plain")
            if effort is not None and is_share(roles["effort"].unit):
                effort *= gripper.effort
        if "open" in roles:
            share = float(request.flag(roles["open"], default=True))
        elif "width" in roles:
            share = self._arm.share_of_width(request.signed(roles["width"], "length"))
        else:
            number = request.signed(roles["position"])
            closed, opened = self._driver.closed, self._driver.opened
            share = (number - closed) / (opened - closed)
        return lambda: self._arm.grip_motion(share, max_effort=effort)

    def tool(self, case: Case, request: Request) -> Pose:
        """Return where the tool is that the driver is given, seen from its link."""
        if "transform" in case.roles:
            return request.transform(case.roles["transform"])
        ((pose, _), *_) = request.poses(case.roles["pose"])
        return pose

    def solve(self, case: Case, request: Request) -> Result:
        """Return the pose that joints lead to, or joints that lead to a pose."""
        if "joints" in case.roles:
            (goal, *_) = request.goals(case.roles["joints"], None, "angle")
            full = self._goals.full(goal, is_relative=False)
            self._arm.check(full)
            return Result(pose=self._arm.pose_at(full))
        (pose, *_) = self._goals.poses(
            self._goals.asked_poses(case.roles, request), None, is_relative=False
        )
        seed = None
        if "seed" in case.roles:
            (near, *_) = request.goals(case.roles["seed"], None, "angle")
            seed = self._goals.full(near, is_relative=False) if near else None
        return Result(joints=tuple(self._arm.reach(pose, seed)))

    # How

    def _rate(
        self, request: Request, value: Value | None, is_line: bool, scaling: str
    ) -> tuple[str, float]:
        """Return a speed or acceleration: ('share', s), ('joints', rad/s), ('line', m/s)."""
        factor = float(self._state.get(scaling, 1.0))
        power = "^2" if scaling == "acceleration_scaling" else ""
        units = self._driver.units
        default = f"{units.length if is_line else units.angle}/s{power}"
        if power and is_line and units.length == "cm":
            default = "m/s^2"
        number = None if value is None else request.number(value, "plain", value.unit or default)
        unit = default if value is None or not value.unit else value.unit
        if number is None:
            return "share", min(max(factor, 1e-3), 1.0)
        if is_share(unit):
            return "share", min(max(number * factor, 1e-3), 1.0)
        return ("joints" if unit.startswith(("rad", "deg")) else "line"), number * factor

    def _trajectory(self, message: Any) -> JointTrajectory:
        try:
            return twin_trajectory(message, self._arm.twin, self._arm.scheduler.now_ns)
        except TrajectoryRefusedError as error:
            raise PlanningError("invalid_goal", str(error)) from error

    def _through(
        self,
        goals: Sequence[Sequence[float]],
        speed: tuple[str, float],
        rise: tuple[str, float],
        duration_s: float,
    ) -> JointTrajectory:
        if not goals:
            raise PlanningError("invalid_goal", "a list of 0 points")
        speeds, rises = (
            self._limits(speed, "velocity_limit"),
            self._limits(rise, "acceleration_limit"),
        )
        # A point where the arm is already takes no time, in which it would have to stop.
        before = [self._arm.positions(), *map(list, goals)]
        moved = [goal for last, goal in pairwise(before) if _differ(last, goal)]
        goals = moved or goals[-1:]
        if len(goals) == 1:
            return self._ramped(goals[0], speeds, rises, duration_s)
        here, times, total = self._arm.positions(), [], 0.0
        for goal in goals:
            self._arm.check(goal)
            total += max(self._arm.fastest_s(here, goal, speeds, rises), 1e-3)
            times.append(total)
            here = list(goal)
        scale = max(1.0, duration_s / total)
        return self._arm.through(goals, [time * scale for time in times])

    def _ramped(
        self,
        goal: Sequence[float],
        speeds: Sequence[float] | None,
        rises: Sequence[float] | None,
        duration_s: float,
    ) -> JointTrajectory:
        """Return the move of all joints that leave and arrive together, each on its own ramp."""
        self._arm.check(goal)
        here, joints = self._arm.positions(), self._arm.arm
        ramps = [
            ramp_of_speed(
                max(abs(b - a), 1e-6),
                min(speeds[i], joint.velocity_limit) if speeds else joint.velocity_limit,
                min(rises[i], joint.acceleration_limit) if rises else joint.acceleration_limit,
            )
            for i, (joint, a, b) in enumerate(zip(joints, here, goal, strict=True))
        ]
        time = max(duration_s, *(ramp.duration_s for ramp in ramps))
        longer = [Ramp(time, ramp.rise_s * time / ramp.duration_s) for ramp in ramps]
        return ramped(self._arm.joints, here, list(goal), longer)

    def _limits(self, rate: tuple[str, float], limit: str) -> list[float] | None:
        kind, number = rate
        rated = [getattr(joint, limit) for joint in self._arm.arm]
        if kind == "share":
            return [number * item for item in rated]
        return [number] * len(rated) if kind == "joints" else None

    def _line(
        self, poses: Sequence[Pose], speed: tuple[str, float], duration_s: float
    ) -> JointTrajectory:
        kind, number = speed
        line = self._arm.line(
            poses, speed=number if kind == "line" else math.inf, duration_s=duration_s
        )
        if kind != "share" or number >= 1.0:
            return line
        longer = 1.0 / number
        if duration_s > 0:
            longer = max(1.0, min(longer, duration_s / max(line.duration_s, 1e-6)))
        return JointTrajectory(
            line.joints, line.time * longer, line.position, line.velocity / longer
        )


def _differ(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two postures are apart; of other lengths they are, for a check to report."""
    if len(one) != len(other):
        return True
    return any(abs(a - b) > _SAME for a, b in zip(one, other, strict=True))
