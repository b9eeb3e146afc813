"""The twin's grippers as actions: the two of control_msgs, and the four of franka_gripper."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.action_goal import ActionGoal
from tracerisk.ros.graph.declared_controllers import DeclaredControllers
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointState, PlanningError
from tracerisk.twin.robots.gripper_ends import gripper_ends, position_at, width_at
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.robots.robot_parts import Gripper

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

GRIPPER_COMMAND = "control_msgs/GripperCommand"
PARALLEL_COMMAND = "control_msgs/ParallelGripperCommand"
_CONTROLLER = "GripperActionController"
_OF_POSITIONS = "position_controllers/"  # its GripperActionController heeds no max_effort
_GOAL_TOLERANCE = 0.01  # of that controller by default, in all distributions [rad or m]
_FRANKA_ACTION = re.compile(r"(^|/)(franka|panda|fr3|fer)\w*_gripper/gripper_action$")
_GRASP_EPSILON = 0.005  # of franka_gripper by default [m]
_SAME_WIDTH = 1e-4  # of franka_gripper [m]
_LEAST_FORCE = 1e-4  # with which franka_gripper grasps in ROS 1 [N]
_WELL_SHORT = 0.1  # of the range: so far from their goal fingers hold something, or cannot go on
_FAR_OUT = 2.0  # ranges past its end: nobody closes so hard, it is another unit
_SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}
FRANKA_PACKAGES = ("franka_gripper", "franka_msgs")
"""Where Move, Grasp, Homing and Stop are defined: in ROS 1, and in ROS 2."""


def gripper_of(robot: Robot, name: str) -> Gripper | None:
    """Return the gripper that an action or topic of this name drives, None where none is meant.

    Of several, it is that of the robot's controller which the name contains, else the one whose
    own name it contains, else the only one on the side that it says.
    """
    if len(robot.grippers) <= 1:
        return next(iter(robot.grippers), None)
    parts = name.strip("/").split("/")
    for controller in robot.controllers:
        if controller.name in parts:
            for gripper in robot.grippers:
                if set(controller.joints) & set(gripper.joints):
                    return gripper
    named = next((item for item in robot.grippers if item.name in name), None)
    sides = _sides(name)
    if named is not None or len(sides) != 1:
        return named
    beside = [item for item in robot.grippers if _sides(item.name, *item.joints) == sides]
    return beside[0] if len(beside) == 1 else None


def _sides(*names: str) -> set[str]:
    """Return the sides that names say in a word of their own: left, or right."""
    words = {word for name in names for word in re.split(r"[^A-Za-z]+", name.lower())}
    return {_SIDES[word] for word in words & _SIDES.keys()}


def measured_grip(state: JointState, gripper: Gripper) -> tuple[float, float, float]:
    """Return a gripper's position, and the greatest speed and effort of a finger."""
    at = [state.names.index(name) for name in gripper.joints]
    position = gripper.position({state.names[i]: state.position[i] for i in at})
    return position, max(abs(state.velocity[i]) for i in at), max(abs(state.effort[i]) for i in at)


class GripperServer(TwinNode):
    """Carries out the goals of gripper actions.

    Fingers that stop on an object have reached their goal, with `stalled` set.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._declared = runtime.client(DeclaredControllers)

    @property
    def handlers(self) -> dict[str, Callable[[ActionGoal], None]]:
        """What is done with a goal of each type."""
        named = {"Move": self._move, "Grasp": self._grasp, "Homing": self._homing}
        franka = {
            f"{package}/{name}": handler
            for package in FRANKA_PACKAGES
            for name, handler in {**named, "Stop": self._stop}.items()
        }
        return {
            GRIPPER_COMMAND: self._gripper_command,
            PARALLEL_COMMAND: self._parallel_command,
            **franka,
        }

    def _gripper_command(self, goal: ActionGoal) -> None:
        if _FRANKA_ACTION.search(goal.client.name):
            self._franka_command(goal)
            return
        command = goal.message.command
        # ROS 2's controller of the same name may take effort 0 for "whatever it needs".
        effort = float(command.max_effort) if command.max_effort > 0.0 else None
        own = self._declared.of_topic(goal.client.name)
        if own is not None and own.type.startswith(_OF_POSITIONS):
            effort = None
        wanted = _first(command.position)

        def end(motion: Motion, gripper: Gripper) -> None:
            result = self._messages.part(goal.client.type_name, "Result")
            result.position, result.effort = self._measured(gripper)
            if effort is not None and motion.stalled:
                self._note_weakness(goal, gripper, result.position, wanted, effort)
            self._end_grip(goal, result, motion, result.position - wanted)

        self._start(goal, lambda _: wanted, effort, end)

    def _note_weakness(
        self, goal: ActionGoal, gripper: Gripper, position: float, wanted: float, effort: float
    ) -> None:
        """Report fingers that stop on the way without touching anything, for want of effort."""
        short = abs(min(max(wanted, gripper.least), gripper.opening) - position)
        if short <= _WELL_SHORT * (gripper.opening - gripper.least):
            return
        if any(any(self._twin.touch_on(pad).force) for pad in gripper.pads):
            return
        unit = self._twin.robot.joint(gripper.joints[0]).unit
        self._commands.report(
            "stopped_at_limit",
            f"gripper '{gripper.name}' stopped at {position:.3g} {unit} on its way to {wanted:.3g} "
            f"{unit} and touches nothing: max_effort {effort:g} of the goal cannot move it "
            "further; where the robot's controller does not heed max_effort it goes on",
            goal.stack,
            object_name=gripper.name,
        )

    def _franka_command(self, goal: ActionGoal) -> None:
        """Move or grasp as the action `gripper_action` of franka_gripper; position: of a finger.

        To close is to grasp the width that is asked for, which fails where the fingers stop
        farther from it than the node's `default_grasp_epsilon`. Its nodes take no width beyond
        the range.
        """
        command = goal.message.command
        # In ROS 2 the force does not matter; in ROS 1 nothing is grasped without one.
        is_grasp_by_force = not self._runtime.distro.is_ros2

        def width(gripper: Gripper) -> float:
            return width_at(self._twin.robot, gripper, self._measured(gripper)[0])

        def asked(gripper: Gripper) -> float:
            return width_at(self._twin.robot, gripper, _first(command.position))

        gripper = self._gripper(goal)
        if gripper is None:
            return
        wanted = asked(gripper)
        least, most = (
            width_at(self._twin.robot, gripper, end) for end in (gripper.least, gripper.opening)
        )
        if not least - _SAME_WIDTH <= wanted <= most + _SAME_WIDTH:
            message = (
                f"position {_first(command.position):g} is out of range, for that is "
                f"[{gripper.least:g}, {gripper.opening:g}] for one finger"
            )
            goal.accept()
            self._report(goal, message)
            goal.abort(None, message)
            return
        is_grasp = wanted < width(gripper) and (
            not is_grasp_by_force or abs(command.max_effort) >= _LEAST_FORCE
        )
        inner, outer = self._epsilon(goal.client.name)

        def misses(motion: Motion, gripper: Gripper) -> str:
            if not is_grasp:
                return _stall(motion, gripper)
            value = width(gripper)
            if wanted - inner <= value <= wanted + outer:
                return ""
            return (
                f"the fingers stopped at a width of {value:.4f} m; {wanted:.4f} m was asked for, "
                f"and default_grasp_epsilon allows {wanted - inner:.4f} to {wanted + outer:.4f} m"
            )

        def end(motion: Motion, gripper: Gripper) -> None:
            result = self._messages.part(goal.client.type_name, "Result")
            if motion.outcome == "succeeded":
                result.position, result.reached_goal = width(gripper), True
            goal.end(motion.outcome, result, motion.message)

        effort = float(command.max_effort) if is_grasp and command.max_effort > 0.0 else None
        # A grasp closes until something is held, as that of the action `grasp`.
        to = gripper_ends(self._twin.robot, gripper).closed if is_grasp else command.position
        self._start(goal, lambda _: _first(to), effort, end, misses)

    def _epsilon(self, action: str) -> tuple[float, float]:
        """Return how much narrower and wider than asked for a grasp may be [m]."""
        node = action.rpartition("/")[0]
        values = []
        for side in ("inner", "outer"):
            name = f"{node}/default_grasp_epsilon/{side}"
            tree = self._graph.parameters
            values.append(float(tree.get(name)) if tree.has(name) else _GRASP_EPSILON)
        return values[0], values[1]

    def _parallel_command(self, goal: ActionGoal) -> None:
        """Move the fingers as ROS 2's parallel_gripper_action_controller, by one position."""
        command = goal.message.command
        if len(command.position) != 1:
            message = f"it has {len(command.position)} positions, and a gripper takes one"
            self._report(goal, message)
            goal.reject(message)
            return
        effort = float(command.effort[0]) if len(command.effort) else 0.0

        def end(motion: Motion, gripper: Gripper) -> None:
            result = self._messages.part(goal.client.type_name, "Result")
            position, pressed = self._measured(gripper)
            result.state.name = [gripper.joints[0]]
            result.state.position, result.state.effort = [position], [pressed]
            self._end_grip(goal, result, motion, position - wanted)

        wanted = float(command.position[0])
        self._start(goal, lambda _: wanted, effort if effort > 0.0 else None, end)

    def _end_grip(self, goal: ActionGoal, result: Any, motion: Motion, miss: float) -> None:
        """End the goal of fingers that came to rest [rad or m] from where they were to be.

        A gripper controller of the workspace says how near is enough (`goal_tolerance`), and fails
        where they stop before, even on an object, unless it has `allow_stalling`. Of others the
        fingers have reached their goal with that.
        """
        own = self._declared.of_topic(goal.client.name)
        is_declared = own is not None and _CONTROLLER in own.type
        settings = own.settings if own is not None and is_declared else {}
        tolerance = abs(float(settings.get("goal_tolerance", _GOAL_TOLERANCE)))
        is_near = abs(miss) < tolerance if is_declared else not motion.stalled
        is_at_rest = motion.outcome == "succeeded"
        result.reached_goal = is_at_rest and is_near
        result.stalled = is_at_rest and not is_near
        if result.stalled and is_declared and settings.get("allow_stalling") is not True:
            if not goal.state.is_terminal:
                goal.abort(result, motion.message)
            return
        goal.end(motion.outcome, result, motion.message)

    def _move(self, goal: ActionGoal) -> None:
        def position(gripper: Gripper) -> float:
            return position_at(self._twin.robot, gripper, goal.message.width)

        self._start(goal, position, None, self._ended(goal), _stall)

    def _grasp(self, goal: ActionGoal) -> None:
        asked = goal.message

        def misses(_: Motion, gripper: Gripper) -> str:
            width = width_at(self._twin.robot, gripper, self._measured(gripper)[0])
            least, most = asked.width - asked.epsilon.inner, asked.width + asked.epsilon.outer
            if least <= width <= most:
                return ""
            return (
                f"the fingers stopped at a width of {width:.4f} m; width and epsilon allow "
                f"{least:.4f} to {most:.4f} m"
            )

        # The fingers close until they hold something, then press with the force.
        self._start(
            goal,
            lambda gripper: gripper_ends(self._twin.robot, gripper).closed,
            asked.force or None,
            self._ended(goal),
            misses,
        )

    def _homing(self, goal: ActionGoal) -> None:
        def opened(gripper: Gripper) -> float:
            return gripper_ends(self._twin.robot, gripper).opened

        self._start(goal, opened, None, self._ended(goal), _stall)

    def _stop(self, goal: ActionGoal) -> None:
        gripper = self._gripper(goal)
        if gripper is None:
            return
        goal.accept()
        self._commands.rest(gripper.joints)
        result = self._messages.part(goal.client.type_name, "Result")
        result.success = True
        goal.succeed(result)

    def _ended(self, goal: ActionGoal) -> Callable[[Motion, Gripper], None]:
        def end(motion: Motion, gripper: Gripper) -> None:
            del gripper
            result = self._messages.part(goal.client.type_name, "Result")
            result.success = motion.outcome == "succeeded"
            result.error = "" if result.success else motion.message or motion.outcome
            goal.end(motion.outcome, result, motion.message)

        return end

    def _start(
        self,
        goal: ActionGoal,
        position_of: Callable[[Gripper], float],
        effort: float | None,
        end: Callable[[Motion, Gripper], None],
        misses: Callable[[Motion, Gripper], str] = lambda motion, gripper: "",  # noqa: ARG005
    ) -> None:
        gripper = self._gripper(goal)
        if gripper is None:
            return
        position = position_of(gripper)
        if not math.isfinite(position):
            message = f"its position {position} is not finite"
            self._report(goal, message)
            goal.reject(message)
            return
        goal.accept()
        # A servo pushes on where the fingers cannot go: beyond their range is its end.
        reachable = min(max(position, gripper.least), gripper.opening)
        if abs(position - reachable) > _FAR_OUT * (gripper.opening - gripper.least):
            self._commands.report(
                "foreign_gripper",
                f"gripper '{gripper.name}' was asked for {position:g}, far past its range "
                f"[{gripper.least:g}, {gripper.opening:g}], and went to {reachable:g}: the "
                "controller may mean another gripper; name its robot with --robot",
                goal.stack,
                object_name=gripper.name,
            )
        try:
            motion = self._twin.move_gripper(gripper.name, reachable, max_effort=effort)
        except PlanningError as error:
            self._report(goal, error.message)
            goal.abort(None, error.message)
            return
        self._commands.begin(
            "gripper_command",
            motion,
            goal.stack,
            lambda ended: end(ended, gripper),
            goal=goal,
            misses=lambda ended: misses(ended, gripper),
        )

    def _gripper(self, goal: ActionGoal) -> Gripper | None:
        robot = self._twin.robot
        gripper = gripper_of(robot, goal.client.name)
        if gripper is None:
            names = ", ".join(item.name for item in robot.grippers) or "none"
            message = (
                f"no gripper of robot '{robot.name}' is meant by the name {goal.client.name}; "
                f"it has {names}, whose name or controller the action's name must contain"
            )
            self._report(goal, message)
            goal.reject(message)
        return gripper

    def _measured(self, gripper: Gripper) -> tuple[float, float]:
        position, _, effort = measured_grip(self._twin.joint_state(), gripper)
        return position, effort

    def _report(self, goal: ActionGoal, message: str) -> None:
        self._commands.report(
            "goal_rejected",
            f"action {goal.client.name} refused a goal: {message}",
            goal.stack,
            object_name=goal.client.name,
        )


def _stall(motion: Motion, gripper: Gripper) -> str:
    """Return why fingers that were to move, and not to grasp, did not get there."""
    del gripper
    return motion.message if motion.stalled else ""


def _first(value: Any) -> float:
    return float(value[0]) if hasattr(value, "__len__") else float(value)
