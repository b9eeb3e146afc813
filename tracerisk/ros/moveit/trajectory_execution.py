"""Carry out trajectories on the twin as MoveIt's execution manager does; record the commands."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from tracerisk.errors import one_of
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.recording import Recorder
    from tracerisk.instrument.tracer import Tracer
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.motion.execution import Motion
    from tracerisk.twin.simulation.twin import Twin

START_TOLERANCE = 0.01
"""How far a trajectory may start from where the joints are: MoveIt's default [rad or m]."""


_NOWHERE = frozenset({"planning_failure", "ik_failure", "path_cut"})


class ErrorCode(enum.IntEnum):
    """The values of moveit_msgs/MoveItErrorCodes that move_group answers with."""

    SUCCESS = 1
    FAILURE = 99999
    PLANNING_FAILED = -1
    INVALID_MOTION_PLAN = -2
    CONTROL_FAILED = -4
    PREEMPTED = -7
    START_STATE_IN_COLLISION = -10
    GOAL_IN_COLLISION = -12
    INVALID_GROUP_NAME = -15
    INVALID_GOAL_CONSTRAINTS = -16
    INVALID_ROBOT_STATE = -17
    INVALID_LINK_NAME = -18
    INVALID_OBJECT_NAME = -19
    FRAME_TRANSFORM_FAILURE = -21
    NO_IK_SOLUTION = -31


_CODE_OF_OUTCOME = {
    "succeeded": ErrorCode.SUCCESS,
    "aborted": ErrorCode.CONTROL_FAILED,
    "preempted": ErrorCode.PREEMPTED,
}


@dataclass(slots=True, eq=False)
class Execution:
    """A motion in execution."""

    motion: Motion
    code: ErrorCode | None = None
    """How it ended."""


class TrajectoryExecution:
    """Execute one trajectory at a time: a new one stops the one before.

    A command is recorded when a motion begins, with the stack of the thread that asked, and its
    end when the motion ends, whether or not anybody waits for it.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._twin: Twin = runtime.twin
        self._commands = runtime.client(TwinCommands)
        self._tracer = cast("Tracer", runtime.tracer)
        self._recorder: Recorder = runtime.recorder
        self._live: list[Execution] = []

    def start(
        self,
        trajectory: JointTrajectory,
        *,
        start_tolerance: float = START_TOLERANCE,
        goal: ActionGoal | None = None,
    ) -> Execution | ErrorCode:
        """Start a trajectory and return its execution, or the code with which it is refused.

        With a tolerance of 0 it may start anywhere [rad or m]. `goal` is the goal of an action
        that asks for it.
        """
        stack = self._commands.stack()
        refusal = self._refusal(trajectory, start_tolerance)
        replaced: list[Motion] = []
        if refusal is None:
            replaced = self._stop()
            try:
                motion = self._begin(trajectory)
            except PlanningError as error:
                refusal = error.message
        if refusal is not None:
            self._commands.poll()
            self._commands.refuse("move_group", stack)
            self.report(
                "execution_failure",
                f"a trajectory was not executed: {refusal}",
                target=trajectory.position[-1] if len(trajectory.time) else (),
            )
            return ErrorCode.CONTROL_FAILED
        for other in replaced:
            other.replaced_by = motion
        execution = Execution(motion)
        self._commands.begin(
            "move_group", motion, stack, lambda _: self._ended(execution), goal=goal
        )
        self._live.append(execution)
        return execution

    def refuse(self) -> None:
        """Record that a motion was asked for where the controller stands, and none was found."""
        self._commands.refuse("move_group", self._commands.stack())

    def wait(self, execution: Execution) -> ErrorCode:
        """Wait until an execution has ended and return its code."""
        self._runtime.scheduler.wait_until(
            lambda: execution.motion.outcome != "active", reason="a motion to end"
        )
        self._commands.poll()
        return execution.code if execution.code is not None else ErrorCode.FAILURE

    def stop(self) -> None:
        """Stop what is being executed."""
        self._stop()
        self._commands.poll()

    def _stop(self) -> list[Motion]:
        """Bring what is being executed to rest, and return it."""
        active = [each.motion for each in self._live if each.motion.outcome == "active"]
        for motion in active:
            self._twin.stop(motion.joints)
        return active

    def _ended(self, execution: Execution) -> None:
        self._live.remove(execution)
        execution.code = _CODE_OF_OUTCOME[execution.motion.outcome]

    def report(
        self, kind: str, message: str, *, object_name: str = "", target: Sequence[float] = ()
    ) -> None:
        """Record a finding where the controller stands; the same once, until a retry succeeds.

        `object_name` is what it is about, `target` the goal of what failed.
        """
        scheduler = self._runtime.scheduler
        if kind in _NOWHERE:
            need = Need("start", self._twin.robot.name)
            place = asking_place()
            scheduler.needs.came_nowhere = Missed(need, 0, scheduler.now_ns, place)
        self._commands.report(kind, message, object_name=object_name, target=target)

    def succeeded(self, kind: str, object_name: str, target: Sequence[float]) -> None:
        """Record that what failed where the controller stands has now succeeded."""
        stack = self._tracer.stack()
        if stack:
            self._recorder.succeeded(
                kind, asker=stack[-1].function, object_name=object_name, target=target
            )

    def _begin(self, trajectory: JointTrajectory) -> Motion:
        wanted, grippers = set(trajectory.joints), self._twin.robot.grippers
        gripper = next((one for one in grippers if wanted <= set(one.joints)), None)
        if gripper is None:
            return self._twin.follow(trajectory)
        last = dict(zip(trajectory.joints, trajectory.position[-1].tolist(), strict=True))
        leader = gripper.leader(last, gripper.position(self._twin.joint_state().positions))
        return self._twin.move_gripper(gripper.name, gripper.sign(leader) * last[leader])

    def _refusal(self, trajectory: JointTrajectory, start_tolerance: float) -> str | None:
        if not trajectory.joints or not len(trajectory.time):
            return "it is empty"
        here = self._twin.joint_state().positions
        for name, begin in zip(trajectory.joints, trajectory.position[0], strict=True):
            if name not in here:
                return f"the robot has no joint '{name}'; {one_of(here, name)}"
            # A single point is a goal, not a path; a first point after 0 is still to be reached.
            if len(trajectory.time) == 1 or trajectory.time[0] > 0.0:
                continue
            if start_tolerance > 0.0 and abs(here[name] - begin) > start_tolerance:
                if self._begins_at(trajectory):
                    return None
                return (
                    f"it starts with joint '{name}' at {begin:.4f}, which is now at "
                    f"{here[name]:.4f}, more than {start_tolerance:g} away; plan from the "
                    "present state"
                )
        return None

    def _begins_at(self, trajectory: JointTrajectory) -> bool:
        """Put the arm where its first motion starts, for where it begins is nowhere said."""
        begin = dict(zip(trajectory.joints, trajectory.position[0].tolist(), strict=True))
        if not self._twin.begin_at(begin):
            return False
        text = ", ".join(f"{name} {value:.4g}" for name, value in begin.items())
        self.report(
            "assumed_start",
            f"the arm is assumed to begin where its first motion was planned from: {text}",
        )
        return True
