"""The services of a Universal Robots controller box on the graph, of either ROS.

Source: UniversalRobots/Universal_Robots_ROS_Driver (hardware_interface) and
Universal_Robots_ROS2_Driver (gpio_controller), and the definitions of ros-industrial/ur_msgs.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

_NODE = "/ur_hardware_interface"
_SERVICES = {  # whether it is taken, and what the controller should know
    "set_io": ("SetIO", True, "an output of the controller box moves nothing of the twin"),
    "set_payload": ("SetPayload", True, "the twin's load is what it holds"),
    "set_speed_slider": (
        "SetSpeedSliderFraction",
        False,
        "the twin moves as fast as it is asked to; ask for slower motions",
    ),
}


class UniversalRobotsBox:
    """Takes outputs and the payload, which move no joint, refuses the speed slider, and says so."""

    def __init__(self, runtime: Runtime, messages: TwinMessages, commands: TwinCommands) -> None:
        self._messages = messages
        self._commands = commands
        for name, (kind, is_taken, told) in _SERVICES.items():
            full = f"ur_msgs/{kind}"
            if messages.has_service(full):
                answer = self._answering(full, is_taken, f"{name}: {told}")
                runtime.graph.offer(name, full, answer, node=_NODE)

    def _answering(self, kind: str, is_taken: bool, told: str) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            del request
            self._commands.tell("not_simulated", told, self._commands.stack())
            made = self._messages.response(kind)
            made.success = is_taken
            return made

        return answer
