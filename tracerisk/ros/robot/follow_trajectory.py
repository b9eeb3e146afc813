"""The twin follows trajectories: the action FollowJointTrajectory under any name."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.messages.dialect import nanoseconds, set_time
from tracerisk.ros.robot.trajectory_messages import (
    TrajectoryCode,
    TrajectoryNode,
    TrajectoryRefusedError,
    twin_trajectory,
)
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.twin.motion.execution import GOAL_TOLERANCE, SETTLE_S, GoalTolerance, Motion
from tracerisk.twin.motion.plausible_units import past_limits
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

TYPE = "control_msgs/FollowJointTrajectory"
FEEDBACK_HZ = 20.0
"""How often feedback is sent and path tolerances are looked at: `action_monitor_rate`."""

_NO_TOLERANCE = 1e9
_ERASED_NS = -1_000_000_000
# Where a goal gives a time only: what drivers commonly allow. `goal: 0.1` in
# UniversalRobots/Universal_Robots_ROS2_Driver, ur_robot_driver/config/ur_controllers.yaml.
_LATE = 0.1  # [rad or m]
Array = NDArray[np.float64]


class FollowServer(TrajectoryNode):
    """Carries out the goals of FollowJointTrajectory.

    A goal with joints that the robot lacks, or an ill-formed one, is rejected with the action's
    error code; a new goal on the same joints preempts the one before.
    """

    def on_goal(self, goal: ActionGoal) -> None:
        """Take a goal or reject it."""
        twin, now_ns = self._commands.twin, self._commands.scheduler.now_ns
        asked = self._names.goal(goal.message)
        what, names = f"a goal of action {goal.client.name}", goal.message.trajectory.joint_names
        if self._names.notes(names):
            self._report_unmoved(what, names, goal.stack)
            if not asked.trajectory.joint_names:
                goal.accept()
                goal.succeed(self._result(TrajectoryCode.SUCCESSFUL))
                return
        try:
            trajectory = twin_trajectory(asked.trajectory, twin, now_ns)
        except TrajectoryRefusedError as error:
            self._refuse(goal, error.code, str(error))
            return
        self._note_space(goal.client.name, trajectory.joints, goal.stack)
        trajectory = self._stopped(what, trajectory, goal.stack)
        ignored = self._rules.ignore_tolerances
        limit = _GoalLimit() if ignored else _GoalLimit.of(asked, trajectory.joints)
        goal.accept()
        try:
            motion = twin.follow(trajectory, goal_tolerance=limit.tolerance)
        except PlanningError as error:
            self._report_refused(goal, error.message)
            goal.abort(self._result(TrajectoryCode.INVALID_GOAL, error.message), error.message)
            return
        _Pursuit(self, goal, asked, trajectory, motion, limit)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Bring the joints to rest; the goal ends with their motion."""
        goal.accept_cancel()
        if isinstance(goal.data, _Pursuit):
            goal.data.cancel()

    def _refuse(self, goal: ActionGoal, code: TrajectoryCode, message: str) -> None:
        self._report_refused(goal, message)
        goal.reject(message, self._result(code, message))

    def _report_refused(self, goal: ActionGoal, message: str) -> None:
        points = goal.message.trajectory.points
        self._commands.report(
            "goal_rejected",
            f"action {goal.client.name} refused a goal: {message}",
            goal.stack,
            object_name=goal.client.name,
            target=points[-1].positions if len(points) else (),
        )

    def _result(self, code: TrajectoryCode, message: str = "") -> Any:
        result = self._messages.part(TYPE, "Result")
        result.error_code = int(code)
        result.error_string = message
        return result


@dataclass(frozen=True, slots=True)
class _GoalLimit:
    """How near its goal an arm must be [rad or m], and how long after the time asked for [s].

    `None` is what the controller has by default.
    """

    position: float | None = None
    time_s: float | None = None

    @classmethod
    def of(cls, asked: Any, joints: Sequence[str]) -> _GoalLimit:
        """Return the limits in the message of a goal.

        As in ros2_controllers, joint_trajectory_controller/tolerances.hpp: 0 leaves the default,
        -1 takes the limit away, and another negative time leaves all of the goal's unused.
        """
        time_ns = nanoseconds(asked.goal_time_tolerance)
        if time_ns < 0 and time_ns != _ERASED_NS:
            return cls()
        time_s = {0: None, _ERASED_NS: math.inf}.get(time_ns, time_ns * 1e-9)
        positions = [
            each.position if each.position > 0.0 else _NO_TOLERANCE
            for each in asked.goal_tolerance
            if each.name in joints and each.position != 0.0
        ]
        return cls(min(positions, default=None), time_s)

    @property
    def tolerance(self) -> GoalTolerance:
        """What the twin waits for: it gives up no sooner than the controller does."""
        return GoalTolerance(
            GOAL_TOLERANCE if self.position is None else self.position,
            max(self.time_s or 0.0, SETTLE_S),
        )


class _Pursuit:
    """One goal while its motion goes on."""

    def __init__(
        self,
        server: FollowServer,
        goal: ActionGoal,
        asked: Any,
        trajectory: JointTrajectory,
        motion: Motion,
        limit: _GoalLimit,
    ) -> None:
        self._server = server
        self._goal = goal
        self._names = list(goal.message.trajectory.joint_names)
        self._is_by_joints = asked is goal.message
        self._trajectory = trajectory
        self._motion = motion
        self._commands = server._commands
        self._began_ns = self._commands.scheduler.now_ns
        self._code = TrajectoryCode.GOAL_TOLERANCE_VIOLATED
        self._limit = limit
        self._limits = {
            each.name: each.position
            for each in (() if server._rules.ignore_tolerances else asked.path_tolerance)
            if each.position > 0.0 and each.name in trajectory.joints
        }
        here = self._commands.twin.joint_state().positions
        self._start = np.array([here[name] for name in trajectory.joints])
        goal.data = self
        self._commands.begin("follow_joint_trajectory", motion, goal.stack, self._ended, goal=goal)
        self._schedule()
        if limit.time_s is not None and math.isfinite(limit.time_s):
            ends_ns = nanoseconds(asked.trajectory.points[-1].time_from_start)
            stamp_ns = nanoseconds(asked.trajectory.header.stamp)
            if stamp_ns:
                ends_ns += stamp_ns - EPOCH_NS - self._began_ns
            due_ns = self._began_ns + ends_ns + round(limit.time_s * 1e9)
            scheduler = self._commands.scheduler
            scheduler.call_at(max(due_ns, scheduler.now_ns), self._look_at_goal, background=True)

    def cancel(self) -> None:
        """Bring the joints to rest."""
        if self._motion.outcome == "active":
            self._commands.twin.stop(self._motion.joints)
        self._commands.poll()

    def _schedule(self) -> None:
        scheduler = self._commands.scheduler
        due_ns = scheduler.now_ns + round(1e9 / FEEDBACK_HZ)
        scheduler.call_at(due_ns, self._look, background=True)

    def _look(self) -> None:
        if self._motion.outcome != "active" or self._goal.state.is_terminal:
            return
        desired, rate = self._desired()
        twin = self._commands.twin
        state = twin.joint_state()
        at = [state.names.index(name) for name in self._trajectory.joints]
        actual = np.array([state.position[i] for i in at])
        speed = np.array([state.velocity[i] for i in at])
        for name, wanted, found in zip(self._trajectory.joints, desired, actual, strict=True):
            limit = self._limits.get(name, math.inf)
            if abs(wanted - found) > limit:
                self._code = TrajectoryCode.PATH_TOLERANCE_VIOLATED
                off = f"{abs(wanted - found):.4f} off its path (tolerance {limit:g})"
                twin.abort(self._motion, f"joint '{name}' is {off}")
                return
        feedback = self._server._messages.part(TYPE, "Feedback")
        self._server._messages.stamp(feedback.header, self._commands.scheduler.now_ns)
        feedback.joint_names = self._names
        elapsed_ns = self._commands.scheduler.now_ns - self._began_ns
        for part, positions, velocities in (
            (feedback.desired, desired, rate),
            (feedback.actual, actual, speed),
            (feedback.error, desired - actual, rate - speed),
        ):
            part.positions = self._as_asked(positions)
            part.velocities = self._as_asked(velocities)
            set_time(part.time_from_start, elapsed_ns)
        self._goal.publish_feedback(feedback)
        self._schedule()

    def _as_asked(self, values: Array) -> list[float]:
        """Return values of the trajectory's joints by the names that the goal has."""
        listed: list[float] = values.tolist()
        if self._is_by_joints:
            return listed
        of_joints = dict(zip(self._trajectory.joints, listed, strict=True))
        return [self._server._names.value(name, of_joints) for name in self._names]

    def _look_at_goal(self) -> None:
        """End a goal that is not reached when its time is over."""
        if self._motion.outcome != "active" or self._goal.state.is_terminal:
            return
        twin = self._commands.twin
        here = twin.joint_state().positions
        goals = zip(self._trajectory.joints, self._trajectory.position[-1], strict=True)
        miss, joint, wanted = max(
            (abs(here[name] - wanted), name, wanted) for name, wanted in goals
        )
        if miss <= (_LATE if self._limit.position is None else self._limit.position):
            return
        text = (
            f"joint '{joint}' is {miss:.4f} from its goal when goal_time_tolerance "
            f"({self._limit.time_s:g} s) is over"
        )
        past = past_limits(twin.robot.joint(joint), float(wanted), 0.0)
        if past:
            text += f"; its goal is {past}"
        twin.abort(self._motion, text)

    def _desired(self) -> tuple[Array, Array]:
        """Return the positions and velocities that the trajectory asks for now."""
        time, position = self._trajectory.time, self._trajectory.position
        velocity = self._trajectory.velocity
        if time[0] > 0.0:
            time = np.concatenate(([0.0], time))
            position = np.vstack((self._start, position))
            velocity = np.vstack((np.zeros(len(self._start)), velocity))
        elapsed = (self._commands.scheduler.now_ns - self._began_ns) * 1e-9
        after = int(np.searchsorted(time, elapsed, side="right"))
        if after >= len(time):
            return position[-1], np.zeros(position.shape[1])
        if after == 0:
            return position[0], velocity[0]
        span = time[after] - time[after - 1]
        u = (elapsed - time[after - 1]) / span
        p0, p1 = position[after - 1], position[after]
        m0, m1 = velocity[after - 1] * span, velocity[after] * span
        # The cubic through both ends with their velocities (Hermite).
        place = (
            (2 * u**3 - 3 * u**2 + 1) * p0
            + (u**3 - 2 * u**2 + u) * m0
            + (3 * u**2 - 2 * u**3) * p1
            + (u**3 - u**2) * m1
        )
        rate = (
            (6 * u**2 - 6 * u) * (p0 - p1) + (3 * u**2 - 4 * u + 1) * m0 + (3 * u**2 - 2 * u) * m1
        ) / span
        return place, rate

    def _ended(self, motion: Motion) -> None:
        goal, result = self._goal, self._server._result
        if goal.state.is_terminal:
            return
        if motion.outcome == "succeeded":
            goal.succeed(result(TrajectoryCode.SUCCESSFUL, motion.message))
        elif motion.outcome == "aborted":
            goal.abort(result(self._code, motion.message), motion.message)
        else:
            text = "" if goal.state is GoalState.PREEMPTING else "a new command took the joints"
            goal.cancel(result(TrajectoryCode.SUCCESSFUL, text), text)
