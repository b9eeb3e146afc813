"""The settings and the recovery of franka_control on the graph.

Source: frankaemika/franka_ros, franka_control (services.cpp, franka_control_node.cpp). In its
first releases the messages were franka_control's own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.action_graph import ActionGoal
from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

PACKAGES = ("franka_msgs", "franka_control")
RECOVERIES = tuple(f"{package}/ErrorRecovery" for package in PACKAGES)

_NODE = "/franka_control"
_SETTINGS = {
    "set_joint_impedance": "SetJointImpedance",
    "set_cartesian_impedance": "SetCartesianImpedance",
    "set_EE_frame": "SetEEFrame",
    "set_K_frame": "SetKFrame",
    "set_force_torque_collision_behavior": "SetForceTorqueCollisionBehavior",
    "set_full_collision_behavior": "SetFullCollisionBehavior",
    "set_load": "SetLoad",
}


class FrankaSettings:
    """Takes the settings of the control box, which the twin's servos do not have, and says so."""

    def __init__(self, runtime: Runtime, messages: TwinMessages, commands: TwinCommands) -> None:
        self._messages = messages
        self._commands = commands
        for package in PACKAGES:
            for name, kind in _SETTINGS.items():
                full = f"{package}/{kind}"
                if messages.has_service(full):
                    runtime.graph.offer(name, full, self._taker(name, full), node=_NODE)

    def _taker(self, name: str, kind: str) -> Callable[[Any], Any]:
        def take(request: Any) -> Any:
            del request
            self._commands.tell(
                "not_simulated",
                f"{name} was taken and changes nothing: the twin's joints keep their own servos",
                self._commands.stack(),
            )
            answer = self._messages.response(kind)
            answer.success = True
            return answer

        return take

    def recover(self, goal: ActionGoal) -> None:
        """Recover from an error; the twin's arm has none that lasts."""
        goal.accept()
        goal.succeed(self._messages.part(goal.client.type_name, "Result"))

    def on_cancel(self, goal: ActionGoal) -> None:
        """Do nothing: a recovery is over as soon as it is asked for."""
        goal.accept_cancel()
