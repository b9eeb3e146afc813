"""The motions that a described driver makes of what it is asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from tracerisk.errors import one_of
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.robot.arm_motion import ArmMotion, TwistFrame
from tracerisk.ros.robot.motion_profiles import Ramp, ramp_of_speed, ramped
from tracerisk.ros.robot.trajectories.joint_names import JointNames
from tracerisk.ros.robot.trajectory_messages import TrajectoryRefusedError, twin_trajectory
from tracerisk.ros.transforms.poses import compose, inverse, multiply
from tracerisk.ros.vendors.answers import Result
from tracerisk.ros.vendors.description import Case, Driver, Value, is_share
from tracerisk.ros.vendors.message_paths import is_of_ros
from tracerisk.ros.vendors.requests import Goal, Request
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

_SAME = 1e-6  # postures of which no joint is further apart are one [rad or m]
_MOTIONS = "motions"  # the parameters of play_motion: motions/NAME/{joints, points}

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
            points = self._joint_goals(roles, request)

            def by_joints() -> JointTrajectory:
                goals = [self._full(point, is_relative=is_relative) for point in points]
                if is_line:
                    return self._line(
                        [self._arm.pose_at(goal) for goal in goals], speed, duration_s
                    )
                return self._through(goals, speed, rise, duration_s)

            return by_joints
        frame = request.word(roles.get("frame"))
        asked = self._asked_poses(roles, request)

        def by_pose() -> JointTrajectory:
            poses = self._poses(asked, frame, is_relative=is_relative)
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
            (goal, *more) = self._joint_goals(case.roles, request)
            if more:
                return None
            full = self._full(goal, is_relative=is_relative)
        else:
            asked = self._asked_poses(case.roles, request)
            frame = request.word(case.roles.get("frame"))
            at = None if before is None else self._arm.pose_at(before)
            (pose, *_) = self._poses(asked, frame, is_relative=is_relative, here=at)
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
            self._check_count(goal)
            named = dict(zip(self._arm.joints, goal, strict=False))
        named = self._by_joints(named)
        self._check_names(named)
        if self._is_in_degrees(value, request):
            degrees = [math.degrees(named.get(name, 0.0)) for name in self._arm.joints]
            self._arm.look_at_degrees_per_s(_asked_by(value), degrees)
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
            full = self._full(goal, is_relative=False)
            self._arm.check(full)
            return Result(pose=self._arm.pose_at(full))
        (pose, *_) = self._poses(self._asked_poses(case.roles, request), None, is_relative=False)
        seed = None
        if "seed" in case.roles:
            (near, *_) = request.goals(case.roles["seed"], None, "angle")
            seed = self._full(near, is_relative=False) if near else None
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

    def _joint_goals(self, roles: Mapping[str, Value], request: Request) -> list[Goal]:
        if "named" in roles:
            return self._named(str(request.word(roles["named"])))
        value = roles["joints"]
        constant = value.constant
        if isinstance(constant, int | float) and not isinstance(constant, bool):
            value = replace(value, constant=[constant] * len(self._arm.joints))
        goals = request.goals(value, roles.get("joint_names"), "angle")
        for goal in goals:
            if not isinstance(goal, Mapping):
                self._check_count(goal)
        is_relative = request.flag(roles.get("relative"), default=False)
        if self._is_in_degrees(value, request) and not is_relative:
            for goal in goals:
                listed = goal.values() if isinstance(goal, Mapping) else goal
                degrees = [math.degrees(item) for item in listed][: len(self._arm.joints)]
                self._arm.look_at_degrees(_asked_by(value), degrees)
        return goals

    def _check_count(self, values: Sequence[float]) -> None:
        """Raise PlanningError where there is not one value a joint; those of several arms' messages
        have room for the joints of the longest."""
        count = len(self._arm.joints)
        if len(values) < count or any(values[count:]):
            raise PlanningError("wrong_count", f"{len(values)} joint values for {count} joints")

    def _is_in_degrees(self, value: Value, request: Request) -> bool:
        """Return whether a value holds degrees that the sender wrote."""
        unit = value.unit or self._driver.units.angle
        return bool(value.paths) and unit.startswith("deg") and not is_of_ros(request.raw(value))

    def _named(self, name: str) -> list[Goal]:
        """Return the points of a motion in the parameters, or a named state of the robot."""
        robot = self._arm.twin.robot
        states = robot.named_states.get(self._arm.group or "", {})
        tree = self._runtime.graph.parameters
        ending = f"/{_MOTIONS}/{name}/joints"
        names = [text for text in tree.names() if text.endswith(ending)]
        # What the files around the controller hold is found by its whole name.
        own = f"{self._driver.node}{ending}"
        if not names and tree.has(own):
            names = [own]
        if not names and name in states:
            state = states[name].items()
            return [{key: value for key, value in state if key in self._arm.joints}]
        if not names:
            known = {text.split("/")[-2] for text in tree.names() if f"/{_MOTIONS}/" in text}
            raise PlanningError(
                "bad_request",
                f"no named state or motion '{name}'; {one_of({*states, *known}, name)}",
            )
        motion = tree.get(names[0].removesuffix("/joints"))
        try:
            rows = [list(map(float, item["positions"])) for item in motion["points"]]
            named = [dict(zip(motion["joints"], row, strict=True)) for row in rows]
        except (KeyError, TypeError, ValueError) as error:
            raise PlanningError("invalid_goal", f"motion '{name}' is malformed: {error}") from error
        # A motion may move other joints too: those of a head, of a gripper.
        arm = set(self._arm.joints)
        return [{key: value for key, value in row.items() if key in arm} for row in named]

    def _full(self, goal: Goal, *, is_relative: bool) -> list[float]:
        """Return a goal of all joints: those that are not named stay where they are."""
        here = self._arm.positions()
        if isinstance(goal, Mapping):
            goal = self._by_joints(goal)
            self._check_names(goal)
            stay = [0.0] * len(here) if is_relative else here
            goal = [goal.get(name, at) for name, at in zip(self._arm.joints, stay, strict=True)]
        # Messages of several arms have room for the joints of the longest.
        values = list(goal)
        if len(values) > len(here) and not any(values[len(here) :]):
            values = values[: len(here)]
        if is_relative and len(values) == len(here):
            values = [a + b for a, b in zip(here, values, strict=True)]
        return values

    def _by_joints(self, named: Mapping[str, float]) -> Mapping[str, float]:
        """Return values by the robot's own joints, where the driver has other names for some."""
        return self._runtime.client(JointNames).spread([*named], [*named.values()])

    def _check_names(self, named: Mapping[str, float]) -> None:
        unknown = next((name for name in named if name not in self._arm.joints), None)
        if unknown is not None:
            raise PlanningError(
                "invalid_goal",
                f"robot '{self._arm.twin.robot.name}' has no joint '{unknown}'; "
                f"{one_of(self._arm.joints, unknown)}",
            )

    def _asked_poses(
        self, roles: Mapping[str, Value], request: Request
    ) -> list[tuple[Any, Any, str]]:
        """Return position, orientation (None: the present one) and frame of each pose."""
        if "pose" in roles:
            poses = request.poses(roles["pose"])
            if not poses:
                raise PlanningError("invalid_goal", "a list of 0 poses")
            return [(pose.position, pose.orientation, frame) for pose, frame in poses]
        position = request.position(roles["position"]) if "position" in roles else None
        turn = request.orientation(roles["orientation"]) if "orientation" in roles else None
        return [(position, turn, "")]

    def _poses(
        self,
        asked: Sequence[tuple[Any, Any, str]],
        frame: str | None,
        *,
        is_relative: bool,
        here: Pose | None = None,
    ) -> list[Pose]:
        poses: list[Pose] = []
        for position, turn, header in asked:
            here = poses[-1] if poses else here or self._arm.tool_pose()
            if frame == "tool":
                step = Pose(position or (0.0, 0.0, 0.0), turn or (0.0, 0.0, 0.0, 1.0))
                poses.append(compose(here, step))
            elif is_relative:
                x, y, z = (a + b for a, b in zip(here.position, position or (0, 0, 0), strict=True))
                turned = multiply(turn, here.orientation) if turn else here.orientation
                poses.append(Pose((x, y, z), turned))
            else:
                named = header or (frame if frame not in (None, "base") else None)
                base = self._frame(named or self._driver.frame or "")
                seen = compose(inverse(base), here)
                poses.append(
                    compose(base, Pose(position or seen.position, turn or seen.orientation))
                )
        return poses

    def _frame(self, name: str) -> Pose:
        from tracerisk.ros.moveit.move_group import MoveGroupServer

        robot = self._arm.twin.robot
        name = name.lstrip("/")
        if not name or name == robot.base_link:
            return Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        if name in robot.link_names:
            return self._arm.twin.link_pose(name)
        frame = None
        if self._runtime.recorder is not None:
            frame = self._runtime.client(MoveGroupServer).frame(name)
        if frame is None:
            if name == self._driver.frame:
                # What the maker's own base is called where this robot's is called otherwise.
                return Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
            scheduler = self._runtime.scheduler
            scheduler.needs.miss(Need("frame", name, parent=robot.base_link), scheduler.now_ns)
            raise PlanningError("bad_request", f"unknown frame '{name}'")
        return frame

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


def _asked_by(value: Value) -> str:
    """Return what the interface of a value is called: its key begins with kind and name."""
    return value.key.split(".")[1].rsplit("/", 1)[-1]


def _differ(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two postures are apart; of other lengths they are, for a check to report."""
    if len(one) != len(other):
        return True
    return any(abs(a - b) > _SAME for a, b in zip(one, other, strict=True))
