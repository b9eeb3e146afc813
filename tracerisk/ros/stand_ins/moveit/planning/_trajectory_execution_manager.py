"""TrajectoryExecutionManager: trajectories that are pushed, then executed in their order."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from typing import Any

from tracerisk.errors import one_of
from tracerisk.ros.moveit.trajectory_execution import ANYWHERE, ErrorCode, ExecutionRules
from tracerisk.twin.physics.motion import JointTrajectory

from .._library import HandedOut, library, log_error, new
from ..core.controller_manager import ExecutionStatus
from ..core.robot_model import RobotModel
from ..core.robot_state import RobotState
from ..core.robot_trajectory import RobotTrajectory

Done = Callable[[ExecutionStatus], object]
PartDone = Callable[[int], object]


class TrajectoryExecutionManager(HandedOut):
    """Executes trajectories on the twin; its driver is one, whichever controllers are named."""

    @classmethod
    def _of_run(cls) -> TrajectoryExecutionManager:
        status = ExecutionStatus._of(_status="UNKNOWN")
        return cls._of(_library=library(), _pushed=[], _status=status, _rules=ExecutionRules())

    _library: Any
    _pushed: list[JointTrajectory]
    _status: ExecutionStatus
    _running = 0
    _rules: ExecutionRules
    _velocity_scaling = 1.0
    _waits_for_completion = True

    # Controllers

    def is_managing_controllers(self) -> bool:
        """Return whether controllers may be switched: the twin's are always active."""
        return False

    def ensure_active_controllers_for_group(self, group: str) -> bool:
        """Return whether a group can be moved: every group of the robot can."""
        groups = self._library.server.robot.groups
        return group in groups or _no("group", group, groups)

    def ensure_active_controllers_for_joints(self, joints: Iterable[str]) -> bool:
        """Return whether joints can be moved: every joint of the robot can."""
        known = [joint.name for joint in self._library.server.robot.joints]
        return all(joint in known or _no("joint", joint, known) for joint in joints)

    def ensure_active_controller(self, controller: str) -> bool:
        """Return whether a controller is active; the twin's driver serves any name."""
        return True

    def ensure_active_controllers(self, controllers: Sequence[str]) -> bool:
        """Return whether controllers are active; the twin's driver serves any name."""
        return True

    def is_controller_active(self, controller: str) -> bool:
        """Return whether a controller is active; the twin's driver serves any name."""
        return True

    def are_controllers_active(self, controllers: Sequence[str]) -> bool:
        """Return whether controllers are active; the twin's driver serves any name."""
        return True

    # Push and execute

    def push(self, trajectory: Any, controller: str = "", controllers: Sequence[str] = ()) -> bool:
        """Add a RobotTrajectory or JointTrajectory message for execution; return whether it is one.

        A controller, or a list of them, may be named; the twin's driver serves any name.
        """
        message = trajectory
        if hasattr(trajectory, "points"):
            message = new("moveit_msgs/RobotTrajectory")
            message.joint_trajectory = trajectory
        if not hasattr(message, "joint_trajectory"):
            raise TypeError(
                "push(): incompatible function arguments. It takes a RobotTrajectory or a "
                f"JointTrajectory message, not {type(trajectory).__name__}"
            )
        if self._running:
            log_error("Cannot push a new trajectory while another is being executed")
            return False
        model = RobotModel._of_run()
        made = RobotTrajectory(model)
        state = RobotState(model)
        state.joint_positions = self._library.server.positions()
        try:
            made.set_robot_trajectory_msg(state, message)
        except RuntimeError as error:
            log_error(f"a trajectory was not pushed: {error}")
            return False
        whole = made._to_twin()
        names = tuple(message.joint_trajectory.joint_names)
        columns = [whole.joints.index(name) for name in names]
        self._pushed.append(
            JointTrajectory(
                names, whole.time, whole.position[:, columns], whole.velocity[:, columns]
            )
        )
        return True

    def execute(
        self,
        callback: Done | None = None,
        part_callback: PartDone | bool | None = None,
        auto_clear: bool = True,
    ) -> None:
        """Begin to execute what was pushed and go on; `callback` takes the status at the end.

        `part_callback` takes the number of each trajectory that has been executed.
        """
        on_part = None if isinstance(part_callback, bool) else part_callback
        if isinstance(part_callback, bool):
            auto_clear = part_callback
        parts = self._take(auto_clear=auto_clear)
        self._running += 1
        self._status = ExecutionStatus._of(_status="RUNNING")

        def run() -> None:
            status = self._run(parts, on_part)
            if callback is not None:
                with self._callback():
                    callback(status)

        self._library.scheduler.spawn(run, "trajectory execution", is_controllers=False)

    def execute_and_wait(self, auto_clear: bool = True) -> ExecutionStatus:
        """Execute what was pushed and return the status at the end."""
        parts = self._take(auto_clear=auto_clear)
        self._running += 1
        return self._run(parts, None)

    def wait_for_execution(self) -> ExecutionStatus:
        """Wait until nothing is being executed and return the last status."""
        self._library.scheduler.wait_until(
            lambda: self._running == 0, reason="the execution of trajectories to end"
        )
        return self._status

    def get_last_execution_status(self) -> ExecutionStatus:
        """Return the status of what was executed last, or is being executed."""
        self._library.scheduler.touch()
        return self._status

    def stop_execution(self, auto_clear: bool = True) -> None:
        """Stop what is being executed."""
        if auto_clear:
            self._pushed.clear()
        self._library.server.execution.stop()

    def process_event(self, event: str) -> None:
        """Carry out an event: `stop` is the only one there is."""
        if event == "stop":
            self.stop_execution(auto_clear=True)
        else:
            log_error(f"Unknown event type: '{event}'; allowed: 'stop'")

    # Settings

    def enable_execution_duration_monitoring(self, flag: bool) -> None:
        """Stop executions that take too long, or not."""
        self._rules.watches_duration = bool(flag)

    def execution_duration_monitoring(self) -> bool:
        """Return whether it is watched how long executions take."""
        return self._rules.watches_duration

    def set_allowed_execution_duration_scaling(self, scaling: float) -> None:
        """Set by which factor an execution may take longer."""
        self._rules.duration_scaling = float(scaling)

    def allowed_execution_duration_scaling(self) -> float:
        """Return by which factor an execution may take longer."""
        return self._rules.duration_scaling

    def set_allowed_goal_duration_margin(self, margin: float) -> None:
        """Set by how much more an execution may take longer [s]."""
        self._rules.goal_margin_s = float(margin)

    def allowed_goal_duration_margin(self) -> float:
        """Return by how much more an execution may take longer [s]."""
        return self._rules.goal_margin_s

    def set_execution_velocity_scaling(self, scaling: float) -> None:
        """Set the factor of the velocities sent; the times, which count, stay as they are."""
        self._velocity_scaling = float(scaling)

    def execution_velocity_scaling(self) -> float:
        """Return the factor of the velocities sent."""
        return self._velocity_scaling

    def set_allowed_start_tolerance(self, tolerance: float) -> None:
        """Set how far from the robot a trajectory may start [rad or m]; 0 is any distance."""
        self._rules.start_tolerance = float(tolerance)

    def allowed_start_tolerance(self) -> float:
        """Return how far from the robot a trajectory may start [rad or m]."""
        return self._rules.start_tolerance

    def set_wait_for_trajectory_completion(self, flag: bool) -> None:
        """Wait for the robot to stand at the end, or not; the twin's motions end at rest."""
        self._waits_for_completion = bool(flag)

    def wait_for_trajectory_completion(self) -> bool:
        """Return whether an execution ends when the robot stands."""
        return self._waits_for_completion

    # How

    def _read(self, parameter: Callable[[str, Any], Any]) -> None:
        """Take the node's parameters below `trajectory_execution`, where it has them."""
        rules = self._rules

        def read(name: str, default: Any) -> Any:
            return type(default)(parameter(f"trajectory_execution.{name}", default))

        rules.watches_duration = read("execution_duration_monitoring", rules.watches_duration)
        rules.duration_scaling = read("allowed_execution_duration_scaling", rules.duration_scaling)
        rules.goal_margin_s = read("allowed_goal_duration_margin", rules.goal_margin_s)
        rules.start_tolerance = read("allowed_start_tolerance", rules.start_tolerance)

    def _take(self, *, auto_clear: bool) -> list[JointTrajectory]:
        parts = list(self._pushed)
        if auto_clear:
            self._pushed.clear()
        return parts

    def _run(
        self, parts: Sequence[JointTrajectory], part_callback: PartDone | None
    ) -> ExecutionStatus:
        """Execute trajectories one after the other, up to the first that does not succeed."""
        status = ExecutionStatus._of(_status="SUCCEEDED")
        for number, part in enumerate(parts):
            # Where the first one starts is checked, no other.
            code = self._carry_out(part, self._rules if number == 0 else ANYWHERE)
            if code is not ErrorCode.SUCCESS:
                status = ExecutionStatus._of_code(code)
                break
            if part_callback is not None:
                with self._callback():
                    part_callback(number)
        self._running -= 1
        self._status = status
        return status

    def _carry_out(self, part: JointTrajectory, rules: ExecutionRules) -> ErrorCode:
        execution = self._library.server.execution
        started = execution.start(part, rules=rules)
        if isinstance(started, ErrorCode):
            return started
        code: ErrorCode = execution.wait(started)
        return code

    def _execute(self, trajectory: RobotTrajectory | None, *, blocking: bool) -> ExecutionStatus:
        """Execute a planned trajectory, as MoveItPy does."""
        if trajectory is None:
            log_error("Robot trajectory is undefined")
            return ExecutionStatus._of(_status="ABORTED")
        parts = [copy.deepcopy(trajectory)._to_twin()]
        self._running += 1
        if blocking:
            return self._run(parts, None)
        self._status = ExecutionStatus._of(_status="RUNNING")
        self._library.scheduler.spawn(
            lambda: self._run(parts, None), "trajectory execution", is_controllers=False
        )
        return self._status

    def _callback(self) -> Any:
        tracer = self._library.tracer
        return nullcontext() if tracer is None else tracer.root("callback")


def _no(what: str, name: str, known: Iterable[str]) -> bool:
    log_error(f"the robot has no {what} '{name}'; {one_of(known, name)}")
    return False
