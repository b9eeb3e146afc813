"""Carry out trajectories on the twin as MoveIt's execution manager does; record the commands."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol, cast

import numpy as np

from tracerisk.errors import one_of
from tracerisk.ros.controller.needs import Missed, Need, asking_place
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.recorder import Recorder
    from tracerisk.instrument.tracer import Tracer
    from tracerisk.ros.graph.action_goal import ActionGoal
    from tracerisk.ros.graph.runtime import Runtime
    from tracerisk.twin.motion.execution import Motion
    from tracerisk.twin.simulation.twin import Twin

START_TOLERANCE = 0.01
"""How far a trajectory may start from where the joints are: MoveIt's default [rad or m]."""

NOTHING = JointTrajectory((), np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)))
"""The trajectory without a point."""

Asker = Literal["move_action", "execute_trajectory", "pickup", "place", "program"]
"""Who asks MoveIt to execute: one of its actions, or a program that holds the manager itself."""


@dataclass(slots=True)
class ExecutionRules:
    """How MoveIt watches what it executes; the defaults are its own.

    Source: moveit/moveit and moveit/moveit2, trajectory_execution_manager.cpp.
    """

    start_tolerance: float = START_TOLERANCE
    """How far each joint may be from a trajectory's first point [rad or m]; 0: anywhere."""
    joint_start_tolerance: Mapping[str, float] = field(default_factory=dict)
    """The same of single joints, which goes before the one of all."""
    watches_duration: bool = True
    """Whether a motion is stopped that takes too long."""
    duration_scaling: float = 1.1
    """By which factor a motion may take longer than its trajectory."""
    goal_margin_s: float = 0.5
    """By how much more it may take longer [s]."""

    def longest_s(self, trajectory: JointTrajectory) -> float:
        """Return for how long a trajectory may be executed [s]."""
        return float(trajectory.time[-1]) * self.duration_scaling + self.goal_margin_s

    def tolerance(self, joint: str) -> float:
        """Return how far a joint may be from the first point [rad or m]; 0: anywhere."""
        return self.joint_start_tolerance.get(joint, self.start_tolerance)


ANYWHERE = ExecutionRules(start_tolerance=0.0)
"""The rules by which a trajectory may start anywhere."""


_NOWHERE = frozenset({"planning_failure", "ik_failure", "path_cut"})


class ErrorCode(enum.IntEnum):
    """The values of moveit_msgs/MoveItErrorCodes that move_group answers with."""

    SUCCESS = 1
    FAILURE = 99999
    PLANNING_FAILED = -1
    INVALID_MOTION_PLAN = -2
    CONTROL_FAILED = -4
    TIMED_OUT = -6
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
    """The motion on the twin."""
    by: Asker = "program"
    """Who asked for it."""
    code: ErrorCode | None = None
    """How it ended, or will end as soon as its motion is at rest."""


class OnBegin(Protocol):
    """What is called with an execution that begins."""

    def __call__(self, execution: Execution, *, is_of_goal: bool) -> None:
        """Take an execution; `is_of_goal` says whether an action's goal asked for it."""


class TrajectoryExecution:
    """Execute one trajectory at a time, as MoveIt's manager does.

    While one is executed, another is refused. Only a new goal of the same action of MoveIt 1 ends
    the one before: `preempts`. A command is recorded when a motion begins, with the stack of the
    thread that asked, and its end when the motion ends, whether or not anybody waits for it.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._twin: Twin = runtime.twin
        self._commands = runtime.client(TwinCommands)
        self._states = runtime.client(ControllerStates)
        self._tracer = cast("Tracer", runtime.tracer)
        self._recorder: Recorder = runtime.recorder
        self._live: list[Execution] = []
        self.on_begin: OnBegin = lambda *_, **__: None
        """Called with each execution that begins, and whether it is that of an action's goal."""
        self.on_end: Callable[[Execution], None] = lambda _: None
        """Called with each execution that has ended."""
        self.on_refused: Callable[[ErrorCode], None] = lambda _: None
        """Called with the code of each motion that was asked for and not found."""

    def start(
        self,
        trajectory: JointTrajectory,
        *,
        by: Asker = "program",
        preempts: bool = False,
        rules: ExecutionRules | None = None,
        goal: ActionGoal | None = None,
        first: Mapping[str, float] | None = None,
    ) -> Execution | ErrorCode:
        """Start a trajectory and return its execution, or the code with which it is answered.

        With `preempts` it takes the place of what `by` asked for before. `goal` is the goal of an
        action that asks for it. `first` is its first point where that is no longer in it
        [rad or m].
        """
        rules = self._rules() if rules is None else rules
        stack = self._commands.stack()
        before = [item for item in self._active() if preempts and item.by == by]
        others = [item for item in self._active() if item not in before]
        if not others and self._moves_nothing(trajectory, rules):
            self.give_way(by if preempts else None)
            return self._answer_empty()
        refusal: str | None = self._states.without_program(trajectory.joints) or None
        if refusal is None:
            refusal = _busy(others[0]) if others else self._refusal(trajectory, rules, first)
        motion: Motion | None = None
        if refusal is None:
            for item in before:
                self._twin.stop(item.motion.joints)
            try:
                motion = self._begin(trajectory)
            except PlanningError as error:
                refusal = error.message
        if motion is None:
            self._commands.poll()
            self.give_way(by if preempts else None)
            self._commands.refuse("move_group", stack)
            self.report(
                "execution_failure",
                f"a trajectory was not executed: {refusal}",
                target=trajectory.position[-1] if len(trajectory.time) else (),
            )
            return ErrorCode.CONTROL_FAILED
        for item in before:
            item.motion.replaced_by, item.code = motion, ErrorCode.PREEMPTED
        execution = Execution(motion, by)
        self._commands.begin(
            "move_group", motion, stack, lambda _: self._ended(execution), goal=goal
        )
        self._live.append(execution)
        self.on_begin(execution, is_of_goal=goal is not None)
        if rules.watches_duration and not set(motion.elements) - set(motion.joints):
            self._watch(execution, rules.longest_s(trajectory))
        return execution

    def give_way(self, to: Asker | None) -> None:
        """Stop what an action executes, for which a new goal came that moves nothing itself."""
        for execution in self._active():
            if execution.by == to:
                self._break_off(
                    execution,
                    ErrorCode.PREEMPTED,
                    f"a new goal of {to} ended it, which MoveIt does even for a plan alone or a "
                    "goal that then fails; wait for its end first",
                )

    def refuse(self, code: ErrorCode = ErrorCode.FAILURE) -> None:
        """Record that a motion was asked for where the controller stands, and none was found."""
        self._commands.refuse("move_group", self._commands.stack())
        self.on_refused(code)

    def wait(self, execution: Execution) -> ErrorCode:
        """Wait until an execution has ended and return its code."""
        self._runtime.scheduler.wait_until(
            lambda: execution.motion.outcome != "active", reason="a motion to end"
        )
        self._commands.poll()
        return execution.code if execution.code is not None else ErrorCode.FAILURE

    def stop(self, by: Asker | None = None) -> None:
        """Stop what is being executed, of one asker alone or as the event `stop` does.

        What that event stops of `move_action` has failed for it; all else was preempted.
        """
        if by is None:
            self._commands.stop_came("a stop of MoveIt")
        for execution in self._active():
            if by is None and execution.by == "move_action":
                execution.code = ErrorCode.CONTROL_FAILED
            if by in (None, execution.by):
                self._twin.stop(execution.motion.joints)
        self._commands.poll()

    def _rules(self) -> ExecutionRules:
        """Return the rules of move_group: its private parameters, else MoveIt's defaults."""
        parameters = self._runtime.graph.parameters

        def read(name: str, default: Any) -> Any:
            full_name = f"/move_group/trajectory_execution/{name}"
            return parameters.get(full_name) if parameters.has(full_name) else default

        of_joints = read("joints_allowed_start_tolerance", {})
        return ExecutionRules(
            start_tolerance=float(read("allowed_start_tolerance", START_TOLERANCE)),
            joint_start_tolerance={name: value for name, value in of_joints.items() if value >= 0},
            watches_duration=bool(read("execution_duration_monitoring", True)),
            duration_scaling=float(read("allowed_execution_duration_scaling", 1.1)),
            goal_margin_s=float(read("allowed_goal_duration_margin", 0.5)),
        )

    def _active(self) -> list[Execution]:
        return [execution for execution in self._live if execution.motion.outcome == "active"]

    def _break_off(self, execution: Execution, code: ErrorCode, why: str) -> None:
        """Bring a motion to rest that the controller did not ask to stop."""
        execution.code = code
        self._twin.abort(execution.motion, why)
        self._commands.poll()

    def _watch(self, execution: Execution, longest_s: float) -> None:
        scheduler = self._runtime.scheduler

        def check() -> None:
            if execution.motion.outcome != "active":
                return
            here = self._twin.joint_state().positions
            motion = execution.motion
            left = {
                name: abs(goal - here[name])
                for name, goal in zip(motion.elements, motion.goal, strict=True)
                if name in here
            }
            why = f"MoveIt stopped it after {longest_s:.3g} s, the longest that it allows"
            if left:
                farthest = max(left, key=lambda name: left[name])
                why += f"; joint '{farthest}' is {left[farthest]:.4f} from its goal"
            pressed = self._twin.pressed()
            if pressed is not None:
                why += f"; '{pressed[0]}' presses on '{pressed[1]}'"
            self._break_off(execution, ErrorCode.TIMED_OUT, why)

        scheduler.call_at(scheduler.now_ns + round(longest_s * 1e9), check, background=True)

    def _ended(self, execution: Execution) -> None:
        self._live.remove(execution)
        if execution.code is None:
            execution.code = _CODE_OF_OUTCOME[execution.motion.outcome]
        self.on_end(execution)

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

    def _moves_nothing(self, trajectory: JointTrajectory, rules: ExecutionRules) -> bool:
        """Return whether MoveIt skips a trajectory that is empty, or has no duration.

        One that leads to where the joints are is not meant.
        """
        if not len(trajectory.time):
            return True
        if trajectory.time[-1] > 0.0 or not self._runtime.distro.value("zero-duration-trajectory"):
            return False
        here = self._twin.joint_state().positions
        last = zip(trajectory.joints, trajectory.position[-1], strict=True)
        return any(
            name in here and abs(here[name] - end) > (rules.tolerance(name) or START_TOLERANCE)
            for name, end in last
        )

    def _answer_empty(self) -> ErrorCode:
        """Report that nothing moves, which MoveIt itself takes for a success."""
        self._commands.report(
            "command_ignored",
            "an execution moves nothing: the trajectory is empty or has no duration, and MoveIt "
            "answers SUCCESS; look at what planning returned first",
        )
        return ErrorCode.SUCCESS

    def _refusal(
        self, trajectory: JointTrajectory, rules: ExecutionRules, first: Mapping[str, float] | None
    ) -> str | None:
        if not len(trajectory.time):
            return None
        here = self._twin.joint_state().positions
        if first is None:
            first = dict(zip(trajectory.joints, trajectory.position[0].tolist(), strict=True))
        for name, begin in first.items():
            if name not in here:
                return f"the robot has no joint '{name}'; {one_of(here, name)}"
            tolerance, away = rules.tolerance(name), abs(here[name] - begin)
            if self._twin.robot.joint(name).type == "continuous":
                away = abs(math.remainder(away, math.tau))
            if tolerance > 0.0 and away > tolerance:
                if self._begins_at(first):
                    return None
                return (
                    f"it starts with joint '{name}' at {begin:.4f}, which is now at "
                    f"{here[name]:.4f}, more than {tolerance:g} away; plan from the "
                    "present state"
                )
        return None

    def _begins_at(self, begin: Mapping[str, float]) -> bool:
        """Put the arm where its first motion starts, for where it begins is nowhere said."""
        if not self._twin.begin_at(begin):
            return False
        text = ", ".join(f"{name} {value:.4g}" for name, value in begin.items())
        self.report(
            "assumed_start",
            f"the arm is assumed to begin where its first motion was planned from: {text}",
        )
        return True


def _busy(other: Execution) -> str:
    return (
        f"MoveIt executes one trajectory at a time, and that of {other.by} still goes on with "
        f"{', '.join(other.motion.elements)}; wait for its end first"
    )
