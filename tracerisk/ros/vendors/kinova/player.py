"""The actions of a Kinova arm: one at a time, reported when they begin and as they end.

Source: Kinovarobotics/ros_kortex, kortex_driver (msg/generated/base, kortex_arm_simulation.cpp).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.services import ServiceFailedError
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.vendors.kinova.actions import POSITION, SPEED, KortexArm, joint_angles
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame

REACH_POSE, REACH_ANGLES = 6, 7
"""Types of actions, as ActionType has them."""
DEFAULTS = {1: ("Retract", "retract"), 2: ("Home", "home"), 3: ("Zero", "vertical")}
"""The actions that every arm has, and the robot's named states that they go to."""

_PACKAGE = "kortex_driver"
_END, _ABORT, _START = 1, 2, 4  # ActionEvent
_OF_KIND = {
    "send_twist_command": 1,
    "send_joint_speeds": 4,
    "reach_pose": REACH_POSE,
    "reach_joint_angles": REACH_ANGLES,
    "apply_emergency_stop": 28,
    "clear_faults": 29,
    "delay": 31,
    "execute_action": 32,
    "send_gripper_command": 33,
    "stop_action": 35,
    "execute_waypoint_list": 41,
}
_FAILED, _IN_EMERGENCY_STOP = 1, 25  # SubErrorCodes
_MIXED = 1
_STOPPED = "the arm is in emergency stop: clear_faults first"

Notify = Callable[[int, int, int, int], None]
_End = Callable[[int, int], None]


class KortexPlayer:
    """Plays actions; `notify` is called with the event, the type, the identifier and the sub-error.

    A new action ends the one before, which is reported as aborted.
    """

    def __init__(
        self, kortex: KortexArm, messages: TwinMessages, commands: TwinCommands, notify: Notify
    ) -> None:
        self._kortex, self._arm = kortex, kortex.arm
        self._messages = messages
        self._commands = commands
        self._scheduler = commands.scheduler
        self._notify = notify
        self._playing: tuple[object, _End] | None = None
        self._at: tuple[str, str] | None = None
        self.created: dict[int, Any] = {}
        self.frame = _MIXED
        self.is_stopped = False

    def stored(self, identifier: int) -> Any:
        """Return an action by its number: created, or one that every arm has."""
        if identifier in self.created:
            return self.created[identifier]
        action = self._messages.new(f"{_PACKAGE}/Action")
        if identifier not in DEFAULTS:
            raise ServiceFailedError(f"there is no action {identifier}")
        name, state = DEFAULTS[identifier]
        robot = self._arm.twin.robot
        states = robot.named_states.get(self._arm.group or "", {})
        item = next((fields for key, fields in states.items() if key.lower() == state), None)
        if item is None:
            known = ", ".join(sorted(states)) or "none"
            raise self.refused(
                f"action {identifier} ({name}) goes to the named state '{state}', which robot "
                f"'{robot.name}' has not; it has {known}"
            )
        action.handle.identifier, action.handle.action_type = identifier, REACH_ANGLES
        action.handle.permission, action.name = 7, name
        angles = self._messages.new(f"{_PACKAGE}/ConstrainedJointAngles")
        values = [item.get(joint, 0.0) for joint in self._arm.joints]
        angles.joint_angles.joint_angles = joint_angles(self._messages, values)
        action.oneof_action_parameters.reach_joint_angles.append(angles)
        return action

    def kind_of(self, action: Any) -> str:
        """Return which of its parameters an action has.

        Raises:
            ServiceFailedError: it has not one, or one that is not simulated.
        """
        parameters = action.oneof_action_parameters
        given = [name for name in parameters.__slots__ if getattr(parameters, name)]
        if len(given) != 1:
            raise ServiceFailedError(
                f"action '{action.name}' has {len(given)} kinds of parameters, not one"
            )
        if given[0] not in _OF_KIND:
            raise self.refused(f"actions of {given[0]} are not simulated: nothing moved")
        return str(given[0])

    def execute(self, action: Any) -> None:
        """Play an action as a message Action describes it."""
        kind = self.kind_of(action)
        asked = getattr(action.oneof_action_parameters, kind)[0]
        self.do(kind, asked, action.handle.identifier)

    def do(self, kind: str, asked: Any, identifier: int, *, is_answered: bool = True) -> None:
        """Play an action of a kind; what cannot move raises where the caller `is_answered`."""
        number = _OF_KIND[kind]
        if kind == "send_gripper_command":
            self._grip(asked)
        elif kind == "execute_action":
            self.execute(self.stored(asked.identifier))
        elif kind in ("stop_action", "apply_emergency_stop", "clear_faults"):
            self.is_stopped = kind == "apply_emergency_stop" or (
                self.is_stopped and kind == "stop_action"
            )
            if kind != "clear_faults":
                self.stop()
        elif kind == "delay":
            self._delay(asked.duration, identifier)
        elif kind in ("send_joint_speeds", "send_twist_command"):
            self._at_speed(kind, asked, is_answered=is_answered)
        else:
            make = {
                "reach_pose": self._kortex.reach_pose,
                "reach_joint_angles": self._kortex.reach_angles,
                "execute_waypoint_list": self._kortex.waypoints,
            }[kind]
            self.play(lambda: make(asked), number, identifier)

    def _begin(self, kind: int, identifier: int) -> _End:
        """Begin an action, which ends the one before, and return what reports its end."""
        self.interrupt()
        token = object()

        def end(event: int, detail: int) -> None:
            if self._playing is not None and self._playing[0] is token:
                self._playing = None
                self._notify(event, kind, identifier, detail)

        self._playing = (token, end)
        self._notify(_START, kind, identifier, 0)
        return end

    def interrupt(self) -> None:
        """End the action that is played, as aborted."""
        self._at = None
        if self._playing is not None:
            self._playing[1](_ABORT, _FAILED)
            self._arm.stop()

    def play(self, make: Callable[[], JointTrajectory], kind: int, identifier: int = 0) -> None:
        """Follow what `make` returns; where it cannot be followed the action is aborted."""
        stack = self._commands.stack()
        end = self._begin(kind, identifier)
        if self.is_stopped:
            self.report_idle(_STOPPED, stack)
            end(_ABORT, _IN_EMERGENCY_STOP)
            return
        try:
            trajectory = make()
        except PlanningError as error:
            self.report_idle(error.message, stack)
            end(_ABORT, _FAILED)
            return

        def ended(motion: Motion) -> None:
            if motion.outcome == "succeeded":
                end(_END, 0)
                return
            end(_ABORT, _FAILED)

        self._arm.start("kortex_action", trajectory, stack, ended, what="an action")

    def _at_speed(self, kind: str, asked: Any, *, is_answered: bool) -> None:
        stack = self._commands.stack()
        key = (kind, str(asked))
        if self._at == key and self._arm.twin.busy:
            return
        self.interrupt()
        if self.is_stopped:
            self.report_idle(_STOPPED, stack)
            if is_answered:
                raise ServiceFailedError(_STOPPED)
            return
        try:
            if kind == "send_joint_speeds":
                trajectory = self._kortex.joint_speeds(asked)
            else:
                trajectory = self._kortex.twist(asked, self.frame)
        except PlanningError as error:
            self.report_idle(error.message, stack)
            if is_answered:
                raise ServiceFailedError(error.message) from error
            return
        self._at = key
        if trajectory is None:
            self._arm.stop()
        else:
            self._arm.start("kortex_velocity", trajectory, stack)

    def _delay(self, seconds: int, identifier: int) -> None:
        end = self._begin(_OF_KIND["delay"], identifier)
        due_ns = self._scheduler.now_ns + seconds * 1_000_000_000
        self._scheduler.call_at(due_ns, lambda: end(_END, 0))

    def _grip(self, asked: Any) -> None:
        stack = self._commands.stack()
        fingers = asked.gripper.finger
        if len(fingers) != 1:
            raise ServiceFailedError(f"{len(fingers)} fingers; there must be exactly one")
        value = float(fingers[0].value)
        if asked.mode not in (SPEED, POSITION):
            raise self.refused(f"gripper mode {asked.mode} is not simulated: nothing moved")
        if asked.mode == SPEED and value == 0.0:
            if self._arm.gripper is not None:
                self._commands.rest(self._arm.gripper.joints)
            return
        # A speed leads to the end of the way, opening where it is above 0.
        opened = 1.0 - value if asked.mode == POSITION else float(value > 0.0)
        try:
            self._arm.move_gripper(opened, stack)
        except PlanningError as error:
            self.report_idle(error.message, stack)
            raise ServiceFailedError(error.message) from error

    def report_idle(self, message: str, stack: tuple[Frame, ...]) -> None:
        """Record that an action moved nothing."""
        self._commands.report("command_ignored", f"an action moved nothing: {message}", stack)

    def stop(self) -> None:
        """Bring arm and fingers to rest."""
        self.interrupt()
        self._arm.stop(fingers=True)

    def refused(self, message: str) -> ServiceFailedError:
        """Record that something is not simulated, and return the error that says so."""
        self._commands.report("not_simulated", message)
        return ServiceFailedError(message)
