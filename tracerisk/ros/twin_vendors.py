"""The drivers of robot makers on the graph, for what their own libraries and controllers ask."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_gazebo import GazeboServices
from tracerisk.ros.twin_interbotix import InterbotixDriver
from tracerisk.ros.twin_messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime


def serve_vendors(runtime: Runtime, messages: TwinMessages, commands: TwinCommands) -> None:
    """Offer each vendor's services and listen to its command topics."""
    InterbotixDriver(runtime, messages, commands)
    if runtime.recorder is not None:
        GazeboServices(runtime, messages, commands)
