"""What drivers of arms share: moves of all joints at once, lines of the tool, and their end.

A driver adds its own units, codes and rules of waiting.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.motion_profiles import Ramp, at_velocities, ramped
from tracerisk.ros.transforms.poses import ORIGIN, angle_between, compose, inverse
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.motion.plausible_units import are_radians_likely, cut_line, shown_limits
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose
from tracerisk.twin.robots.gripper_ends import driver_ends, position_at, width_at
from tracerisk.twin.robots.robot_parts import Scaling

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.twin.robots.robot_parts import Joint

TwistFrame = Literal["base", "tool", "mixed"]
"""In whose axes a twist is: `mixed` has its shift in those of the base, its turn in the tool's."""

_NEAR = 1e-3  # [rad]: how far a goal may be past a limit
_LONGEST_LINE, _LONGEST_TURN = 1.0, 1.5  # [m], [rad]: how far a twist leads by itself


class ArmMotion:
    """Moves the arm of the twin for a driver.

    `tools` are links that the driver speaks of, the first one there is taken; else it is the tip
    of the group of all joints. `group` and `gripper` are names of the robot's, for one of several.
    `offset` is the point that poses are of as seen from that link: a driver may be given it.
    """

    def __init__(
        self,
        commands: TwinCommands,
        tools: Sequence[str] = (),
        *,
        group: str | None = None,
        gripper: str | None = None,
    ) -> None:
        self._commands = commands
        self.scheduler = commands.scheduler
        self.twin = commands.twin
        robot = self.twin.robot
        held = {name for gripper in robot.grippers for name in gripper.joints}
        groups = {
            name: group
            for name, group in robot.groups.items()
            if group.tip_link is not None and not held & set(group.joints)
        }
        # Of several groups the largest, as a description has groups of parts of its arm too.
        largest = max(groups, key=lambda name: len(groups[name].joints), default=None)
        self.group = group if group in groups else largest
        known = [robot.joint(name) for name in groups[self.group].joints] if self.group else ()
        self.arm: tuple[Joint, ...] = tuple(known) or robot.arm_joints
        self.joints = tuple(joint.name for joint in self.arm)
        named = (link for tool in tools for link in robot.link_names if link.endswith(tool))
        self.offset = ORIGIN
        self.tool = next(named, groups[self.group].tip_link if self.group else None)
        named_grippers = (item for item in robot.grippers if gripper in (None, item.name))
        self.gripper = next(named_grippers, None)
        if self.gripper is not None:
            self._ends = driver_ends(robot, self.gripper)

    # Where it is

    def positions(self) -> list[float]:
        """Return where the joints are [rad]."""
        at = self.twin.joint_state().positions
        return [at[name] for name in self.joints]

    def velocities(self) -> list[float]:
        """Return how fast the joints are [rad/s]."""
        state = self.twin.joint_state()
        return [state.velocity[state.names.index(name)] for name in self.joints]

    def efforts(self) -> list[float]:
        """Return the torques of the joints [N m]."""
        state = self.twin.joint_state()
        return [state.effort[state.names.index(name)] for name in self.joints]

    def tool_pose(self) -> Pose:
        """Return where the tool is, in the frame of the robot's base link."""
        return compose(self.twin.link_pose(self.tool or self.twin.robot.base_link), self.offset)

    def pose_at(self, positions: Sequence[float]) -> Pose:
        """Return where the tool is with the joints at `positions` [rad]."""
        named = dict(zip(self.joints, positions, strict=True))
        link = self.tool or self.twin.robot.base_link
        return compose(self.twin.forward_kinematics(named, link), self.offset)

    def reach(self, pose: Pose, seed: Sequence[float] | None = None) -> list[float]:
        """Return joint positions that bring the tool to a pose.

        Raises:
            PlanningError: there are none.
        """
        group = self._planned()
        near = dict(zip(self.joints, seed, strict=False)) if seed else None
        link_pose = compose(pose, inverse(self.offset))
        inverse_kinematics = self.twin.inverse_kinematics(
            group, link_pose, link=self.tool, seed=near
        )
        return [inverse_kinematics[name] for name in self.joints]

    def grip(self) -> float:
        """Return how far the gripper is open: 0 closed, 1 wide open."""
        if self.gripper is None:
            return 0.0
        at = self.twin.joint_state().positions
        return self._ends.share(self.gripper.position(at))

    def grip_width(self) -> float:
        """Return how far the fingers are apart [m]."""
        if self.gripper is None:
            return 0.0
        at = self.twin.joint_state().positions
        return width_at(self.twin.robot, self.gripper, self.gripper.position(at))

    # What it can do

    def check(self, goal: Sequence[float]) -> None:
        """Raise PlanningError for a goal of other joints than the arm has, or past a limit."""
        if len(goal) != len(self.joints):
            raise PlanningError(
                "invalid_goal", f"{len(goal)} joint values for {len(self.joints)} joints"
            )
        for joint, value in zip(self.arm, goal, strict=True):
            if not joint.lower - _NEAR <= value <= joint.upper + _NEAR:
                raise PlanningError(
                    "invalid_goal",
                    f"{value:.3f} for '{joint.name}' is outside its limits "
                    f"{shown_limits(joint, value)}",
                )

    def look_at_degrees(self, name: str, goal: Sequence[float]) -> None:
        """Note a goal of joints in degrees that may be one in radians; `name` asks for it."""
        if are_radians_likely(self.arm, goal):
            values = ", ".join(f"{value:.4g}" for value in goal)
            self._commands.note(
                "unlikely_unit",
                f"{name} takes degrees, and [{values}] (radians?) leads no joint further than "
                f"{max(map(abs, goal)):.3g} degrees from zero",
                name,
            )

    def look_at_degrees_per_s(self, name: str, speeds: Sequence[float]) -> None:
        """Note velocities of joints in deg/s that may be in rad/s; `name` asks for them."""
        pairs = list(zip(self.arm, speeds, strict=False))
        joint, speed = max(pairs, key=lambda pair: abs(pair[1]), default=(None, 0.0))
        if joint is None or not speed or joint.type == "prismatic":
            return
        if all(abs(value) <= member.velocity_limit for member, value in pairs):
            self._commands.note(
                "unlikely_unit",
                f"{name} takes deg/s: {speed:.4g} (rad/s?) turns joint '{joint.name}' by "
                f"{speed:.4g} degrees in a second, and not by {math.degrees(speed):.3g}",
                name,
            )

    def fastest_s(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        speeds: Sequence[float] | None = None,
        rises: Sequence[float] | None = None,
    ) -> float:
        """Return in what time [s] all joints come from `start` to `goal` at the soonest.

        A third of it is for speeding up, a third for slowing down: of a way w the greatest speed
        is then 1.5 w / t, the acceleration 4.5 w / t^2.
        """
        time = 1e-3
        for i, (joint, a, b) in enumerate(zip(self.arm, start, goal, strict=True)):
            speed = min(speeds[i], joint.velocity_limit) if speeds else joint.velocity_limit
            rise = min(rises[i], joint.acceleration_limit) if rises else joint.acceleration_limit
            way = abs(b - a)
            time = max(time, 1.5 * way / speed, math.sqrt(4.5 * way / rise))
        return time

    def to_joints(
        self,
        goal: Sequence[float],
        *,
        speeds: Sequence[float] | None = None,
        rises: Sequence[float] | None = None,
        duration_s: float = 0.0,
    ) -> JointTrajectory:
        """Return the move of all joints, which leave and arrive together.

        `speeds` [rad/s] and `rises` [rad/s^2] bound each joint below its rated figures;
        `duration_s` is taken where it is longer than that.

        Raises:
            PlanningError: the goal is past a limit.
        """
        self.check(goal)
        here = self.positions()
        time = max(self.fastest_s(here, goal, speeds, rises), duration_s)
        return ramped(self.joints, here, list(goal), [Ramp(time, time / 3)] * len(here))

    def through(
        self, points: Sequence[Sequence[float]], times_s: Sequence[float]
    ) -> JointTrajectory:
        """Return the way through joint positions [rad] at times [s], at rest at its end.

        Speeds at the points between are those of a spline through their neighbours.
        """
        for point in points:
            self.check(point)
        rows = np.array([self.positions(), *points])
        times = np.array([0.0, *times_s])
        speeds = np.zeros_like(rows)
        for i in range(1, len(rows) - 1):
            speeds[i] = (rows[i + 1] - rows[i - 1]) / (times[i + 1] - times[i - 1])
        return JointTrajectory(self.joints, times[1:], rows[1:], speeds[1:])

    def line(
        self,
        poses: Sequence[Pose],
        *,
        speed: float = math.inf,
        turn: float = math.inf,
        duration_s: float = 0.0,
        least: float = 1.0,
    ) -> JointTrajectory:
        """Return the way of the tool along straight lines through `poses`.

        `speed` [m/s] and `turn` [rad/s] bound it below what the joints can; `duration_s` is taken
        where it is longer. At least the share `least` of the way must be one the arm can follow.

        Raises:
            PlanningError: it cannot be followed.
        """
        group = self._planned()
        trajectory, fraction = self.twin.plan_cartesian(
            group,
            [compose(pose, inverse(self.offset)) for pose in poses],
            link=self.tool,
            avoid_collisions=False,
            scaling=Scaling(1.0, 1.0),
        )
        here, needed = self.tool_pose(), 0.0
        if fraction < least - 1e-6:
            raise PlanningError("no_ik_solution", cut_line(poses[-1], fraction, here))
        if len(trajectory.time) < 2:
            # The tool is there already.
            return self.to_joints(self.positions(), duration_s=duration_s)
        for pose in poses:
            way = math.dist(here.position, pose.position) / speed
            needed += max(way, angle_between(here.orientation, pose.orientation) / turn)
            here = pose
        # The points lie evenly along the way: each step takes the tool, or the joints, its time.
        steps = np.diff(trajectory.time)
        steps = np.maximum(steps, needed * fraction / len(steps))
        steps *= max(1.0, duration_s / float(steps.sum()))
        time = np.concatenate(([0.0], np.cumsum(steps)))
        velocity = np.gradient(trajectory.position, time, axis=0)
        velocity[0] = velocity[-1] = 0.0
        return JointTrajectory(trajectory.joints, time, trajectory.position, velocity)

    def twist(
        self,
        linear: Sequence[float],
        angular: Sequence[float],
        frame: TwistFrame = "base",
        for_s: float | None = None,
    ) -> JointTrajectory | None:
        """Return the way of the tool at a velocity [m/s, rad/s], None for none.

        It ends after `for_s`, after a metre or 1.5 rad, or where the arm can follow no further.

        Raises:
            PlanningError: the arm cannot follow at all.
        """
        speed, turn = math.hypot(*linear), math.hypot(*angular)
        if max(speed, turn) < 1e-6:
            return None
        ends = [_LONGEST_LINE / speed if speed else math.inf]
        ends.append(_LONGEST_TURN / turn if turn else math.inf)
        ends.append(math.inf if for_s is None else for_s)
        time = min(ends)
        here = self.tool_pose()
        shift, turned = [value * time for value in linear], [value * time for value in angular]
        there = moved(here, shift, turned, frame)
        way = self.line([there], speed=speed or math.inf, turn=turn or math.inf, least=0.02)
        return replace(way, leads="on" if for_s is None else "for_a_while")

    def at_speeds(
        self, speeds: Sequence[float], for_s: float | None = None
    ) -> JointTrajectory | None:
        """Return the way of the joints at velocities [rad/s], None where all are at rest."""
        return at_velocities(self.twin, dict(zip(self.joints, speeds, strict=False)), for_s)

    # Motion

    def start(
        self,
        kind: str,
        trajectory: JointTrajectory,
        stack: tuple[Frame, ...],
        on_end: Callable[[Motion], None] = lambda motion: None,  # noqa: ARG005
        *,
        goal: ActionGoal | None = None,
        what: str = "a motion",
    ) -> Motion:
        """Begin to follow a trajectory for the code of `stack`; see `TwinCommands.begin`."""
        motion = self.twin.follow(trajectory)
        self._commands.begin(kind, motion, stack, on_end, goal=goal, what=what)
        return motion

    def move_gripper(
        self,
        opened: float,
        stack: tuple[Frame, ...],
        *,
        max_effort: float | None = None,
        goal: ActionGoal | None = None,
    ) -> Motion:
        """Move the fingers to a share of their opening: 0 closed, 1 wide open.

        Raises:
            PlanningError: the robot has no gripper with joints.
        """
        motion = self.grip_motion(opened, max_effort=max_effort)
        self._commands.begin("gripper_command", motion, stack, goal=goal)
        return motion

    def grip_motion(self, opened: float, *, max_effort: float | None = None) -> Motion:
        """Start the motion of `move_gripper` without recording whose it is."""
        if self.gripper is None:
            raise PlanningError(
                "bad_request", f"robot '{self.twin.robot.name}' has no gripper with joints"
            )
        goal = self._ends.position(min(max(opened, 0.0), 1.0))
        goal = min(max(goal, self.gripper.least), self.gripper.opening)
        return self.twin.move_gripper(self.gripper.name, goal, max_effort=max_effort)

    def share_of_width(self, width: float) -> float:
        """Return at which share of their opening the fingers are a width apart [m]."""
        if self.gripper is None:
            return 0.0
        return self._ends.share(position_at(self.twin.robot, self.gripper, width))

    def stop(self, *, fingers: bool = False) -> None:
        """Bring the arm to rest, and the fingers where asked."""
        fingertips = self.gripper.joints if fingers and self.gripper is not None else ()
        self._commands.stop((*self.joints, *fingertips))

    def wait(self, motion: Motion, timeout_s: float | None = None) -> bool:
        """Wait in the calling thread for the end of a motion, and return whether it succeeded."""
        self._commands.scheduler.wait_until(
            lambda: motion.outcome != "active",
            timeout_ns=None if timeout_s is None else round(timeout_s * 1e9),
            reason="the arm to finish",
        )
        return motion.outcome == "succeeded"

    def _planned(self) -> str:
        if self.group is None:
            raise PlanningError("bad_request", "the robot has no planning group with a tip link")
        return self.group


def moved(here: Pose, linear: Sequence[float], turned: Sequence[float], frame: TwistFrame) -> Pose:
    """Return a pose after a shift [m] and a turn about one axis (its length the angle) [rad]."""
    angle = math.hypot(*turned)
    scale = math.sin(angle / 2) / angle if angle > 1e-12 else 0.0
    x, y, z = (float(value) * scale for value in turned)
    turn = Pose((0.0, 0.0, 0.0), (x, y, z, math.cos(angle / 2)))
    at_origin = Pose((0.0, 0.0, 0.0), here.orientation)
    turned_pose = compose(turn, at_origin) if frame == "base" else compose(at_origin, turn)
    a, b, c = (float(value) for value in linear)
    shift = Pose((a, b, c), (0.0, 0.0, 0.0, 1.0))
    way = compose(at_origin, shift).position if frame == "tool" else shift.position
    px, py, pz = (p + w for p, w in zip(here.position, way, strict=True))
    return Pose((px, py, pz), turned_pose.orientation)
