"""The twin follows trajectories: the action FollowJointTrajectory under any name."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import Location
from tracerisk.ros.graph.action_goal import ActionGoal, GoalState
from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.trajectories.controllers import (
    TrajectoryController,
    TrajectoryControllers,
)
from tracerisk.ros.robot.trajectories.limits import GoalLimits, goal_limits
from tracerisk.ros.robot.trajectories.timed import left_out
from tracerisk.ros.robot.trajectory_messages import (
    TrajectoryCode,
    TrajectoryNode,
    TrajectoryRefusedError,
    twin_trajectory,
)
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.motion.interpolation import states_at
from tracerisk.twin.motion.plausible_units import past_limits
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

TYPE = "control_msgs/FollowJointTrajectory"
FEEDBACK_HZ = 20.0
"""How often feedback is sent and path tolerances are looked at: `action_monitor_rate`."""

EMPTY = "trajectory-without-points"
REPLACED = "trajectory-goal-replaced"
BY_TOPIC = "trajectory-by-topic-during-goal"
WORDS = "trajectory-result-words"
_REPLACED = {
    "cancelled": "",
    "cancelled as invalid": "Current goal cancelled due to new incoming action.",
    "aborted": "Current goal preempted by new incoming action.",
}
_SUCCESS = {"of the joint": "", "of the controller": "Goal successfully reached!"}
Array = NDArray[np.float64]


class FollowServer(TrajectoryNode):
    """Carries out the goals of FollowJointTrajectory as a controller of joint trajectories does.

    A maker's driver whose description says what it does with trajectories has rules of its own.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._controllers = runtime.client(TrajectoryControllers)
        self._states = runtime.client(ControllerStates)

    def on_goal(self, goal: ActionGoal) -> None:
        """Take a goal or reject it."""
        asked = self._names.goal(goal.message)
        what, names = f"a goal of action {goal.client.name}", goal.message.trajectory.joint_names
        if self._names.notes(names):
            self._report_unmoved(what, names, goal.stack)
            if not asked.trajectory.joint_names:
                goal.accept()
                goal.succeed(self._result(TrajectoryCode.SUCCESSFUL))
                return
        if lost := self._states.lost_arm(goal.client.name):
            goal.accept()
            self._report_refused(goal, lost)
            goal.abort(self._result(TrajectoryCode.PATH_TOLERANCE_VIOLATED, lost), lost)
            return
        if refusal := self._states.refusal(goal.client.name):
            self._refuse(goal, TrajectoryCode.INVALID_GOAL, refusal)
            return
        controller = self._controllers.of(goal.client.name, asked.trajectory.joint_names)
        try:
            trajectory = self._trajectory(goal, asked, controller)
        except TrajectoryRefusedError as error:
            self._refuse(goal, error.code, str(error))
            return
        if trajectory is None:
            self._stop(goal, controller)
            return
        self._note_space(goal.client.name, trajectory.joints, goal.stack)
        trajectory = self._stopped(what, trajectory, goal.stack)
        distro = self._runtime.distro
        limits = (
            GoalLimits()
            if self._rules.ignore_tolerances
            else goal_limits(asked, controller.settings, trajectory.joints, distro)
        )
        goal.accept()
        self._replace(controller, goal)
        try:
            motion = self._twin.follow(trajectory, goal_tolerance=limits.tolerance)
        except PlanningError as error:
            self._report_refused(goal, error.message)
            goal.abort(self._result(TrajectoryCode.INVALID_GOAL, error.message), error.message)
            return
        controller.pursuit = _Pursuit(self, goal, asked, trajectory, motion, limits, controller)

    def on_cancel(self, goal: ActionGoal) -> None:
        """Bring the joints to rest; the goal ends with their motion."""
        goal.accept_cancel()
        if isinstance(goal.data, _Pursuit):
            goal.data.cancel()

    def _trajectory(
        self, goal: ActionGoal, asked: Any, controller: TrajectoryController
    ) -> JointTrajectory | None:
        """Return what the twin follows for a goal, None for one that stops the joints."""
        now_ns = self._commands.scheduler.now_ns
        if self._is_drivers:
            return twin_trajectory(asked.trajectory, self._twin, now_ns)
        sent = controller.asked(asked.trajectory, now_ns)
        controller.check_joints(sent)
        if not sent.points:
            if self._runtime.distro.value(EMPTY) == "stops the joints":
                return None
            raise TrajectoryRefusedError("the trajectory has no points")
        trajectory = controller.trajectory(sent, goal.stack)
        name = goal.client.name
        if words := left_out(sent, self._twin, f"a goal of action {name}"):
            self._commands.report("command_ignored", words, goal.stack, object_name=name)
        return trajectory

    def _stop(self, goal: ActionGoal, controller: TrajectoryController) -> None:
        """Bring the joints to rest for a goal without points, which is reached with that."""
        goal.accept()
        self._replace(controller, goal)
        self._commands.rest(controller.joints)
        goal.succeed(self._result(TrajectoryCode.SUCCESSFUL))

    def _replace(self, controller: TrajectoryController, goal: ActionGoal) -> None:
        """End the goal that the controller pursues, for a new one."""
        if isinstance(controller.pursuit, _Pursuit):
            controller.pursuit.end_for(goal)
        controller.pursuit = None

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


class _Pursuit:
    """One goal while its motion goes on."""

    def __init__(
        self,
        server: FollowServer,
        goal: ActionGoal,
        asked: Any,
        trajectory: JointTrajectory,
        motion: Motion,
        limits: GoalLimits,
        controller: TrajectoryController,
    ) -> None:
        self._server = server
        self._goal = goal
        self._names = list(goal.message.trajectory.joint_names)
        self._is_by_joints = asked is goal.message
        self._motion = motion
        self._commands = server._commands
        self._distro = server._runtime.distro
        self._code = TrajectoryCode.GOAL_TOLERANCE_VIOLATED
        self._limits = limits
        self._controller = controller
        self._ends_s = 0.0
        self._take(motion, trajectory)
        goal.data = self
        self._commands.begin("follow_joint_trajectory", motion, goal.stack, self._ended, goal=goal)
        self._schedule()
        if limits.time_s > 0.0 and math.isfinite(limits.time_s):
            due_s = self._ends_s + limits.time_s
            scheduler = self._commands.scheduler
            due_ns = scheduler.now_ns + round(due_s * 1e9)
            scheduler.call_at(
                due_ns, lambda: self._look_at_goal(motion, trajectory), background=True
            )

    def _take(self, motion: Motion, trajectory: JointTrajectory) -> None:
        self._motion, self._began_ns = motion, self._commands.scheduler.now_ns
        here = self._commands.twin.joint_state().positions
        start = np.array([here[name] for name in trajectory.joints])
        self._trajectory = trajectory.led_in(start, np.zeros(len(start)))
        self._ends_s = float(trajectory.time[-1])

    def cancel(self) -> None:
        """Bring the joints to rest."""
        if self._motion.outcome == "active":
            self._commands.twin.stop(self._motion.joints)
        self._commands.poll()
        if not self._goal.state.is_terminal and self._motion.outcome != "active":
            self._ended(self._motion)

    def end_for(self, other: ActionGoal) -> None:
        """End the goal as a controller ends the one that another goal replaces."""
        if self._goal.state.is_terminal:
            return
        line, column = other.stack[-1].site if other.stack else (0, 0)
        if other.stack:
            place = Location(other.stack[-1].function.file, line, column or None)
            self._distro.decided(REPLACED, place)
        state = str(self._distro.value(REPLACED))
        words = _REPLACED[state]
        code = TrajectoryCode.INVALID_GOAL if words else TrajectoryCode.SUCCESSFUL
        end = self._goal.abort if state == "aborted" else self._goal.cancel
        end(self._server._result(code, words), words)

    def go_on_by(self, motion: Motion, trajectory: JointTrajectory) -> None:
        """See to the goal when a trajectory of a topic takes its joints.

        In ROS 2 the goal is reached where that trajectory ends.
        """
        if self._goal.state.is_terminal or self._motion.replaced_by is not motion:
            return
        if self._distro.value(BY_TOPIC) == "the goal is cancelled":
            self._goal.cancel(self._server._result(TrajectoryCode.SUCCESSFUL))
            return
        self._take(motion, trajectory)
        self._goal.motion = motion
        self._commands.when_over(motion, self._ended)
        self._schedule()

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
        for limits, wanted, array, what in (
            (self._limits.path, desired, actual, "off its path"),
            (self._limits.path_speed, rate, speed, "off the velocity of its path"),
        ):
            misses = np.abs(wanted - array)
            for name, miss in zip(self._trajectory.joints, misses.tolist(), strict=True):
                if miss > limits.get(name, math.inf):
                    self._code = TrajectoryCode.PATH_TOLERANCE_VIOLATED
                    off = f"{miss:.4f} {what} (tolerance {limits[name]:g})"
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

    def _look_at_goal(self, motion: Motion, trajectory: JointTrajectory) -> None:
        """End a goal that is not reached when its time is over."""
        if motion is not self._motion or motion.outcome != "active":
            return
        twin = self._commands.twin
        here = twin.joint_state().positions
        misses = [
            (abs(here[name] - wanted), self._limits.of_joint(name), name, wanted)
            for name, wanted in zip(trajectory.joints, trajectory.position[-1], strict=True)
        ]
        miss, limit, joint, wanted = max(misses, key=lambda found: found[0] / found[1])
        if miss <= limit:
            return
        text = (
            f"joint '{joint}' is {miss:.4f} from its goal when goal_time_tolerance "
            f"({self._limits.time_s:g} s) is over"
        )
        past = past_limits(twin.robot.joint(joint), float(wanted), 0.0)
        if past:
            text += f"; its goal is {past}"
        twin.abort(self._motion, text)

    def _desired(self) -> tuple[Array, Array]:
        """Return the positions and velocities that the trajectory asks for now."""
        asked = self._trajectory
        now = np.array([(self._commands.scheduler.now_ns - self._began_ns) * 1e-9])
        position, velocity = states_at(
            now, asked.time, asked.position, asked.velocity, asked.degree, asked.acceleration
        )
        return position[0], velocity[0]

    def _ended(self, motion: Motion) -> None:
        goal, result = self._goal, self._server._result
        if goal.state.is_terminal or motion is not self._motion:
            return
        if motion.outcome == "succeeded":
            words = str(self._distro.value(WORDS))
            goal.succeed(result(TrajectoryCode.SUCCESSFUL, _SUCCESS[words]))
        elif motion.outcome == "aborted":
            goal.abort(result(self._code, self._failure(motion)), motion.message)
        else:
            text = "" if goal.state is GoalState.PREEMPTING else "a new command took the joints"
            goal.cancel(result(TrajectoryCode.SUCCESSFUL, text), text)

    def _failure(self, motion: Motion) -> str:
        """Return the words of the result of a goal that was not reached, as the controller has."""
        if self._distro.value(WORDS) == "of the joint":
            return motion.message
        if self._code is TrajectoryCode.PATH_TOLERANCE_VIOLATED:
            return "Aborted due to path tolerance violation"
        past_s = (self._commands.scheduler.now_ns - self._began_ns) * 1e-9 - self._ends_s
        return f"Aborted due to goal_time_tolerance exceeding by {past_s:f} seconds"
