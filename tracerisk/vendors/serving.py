"""The drivers of robot makers on the graph, for what their own libraries and controllers ask."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.vendors.dobot.driver import DobotDriver
from tracerisk.vendors.doosan.driver import DoosanController
from tracerisk.vendors.franka.driver import RECOVERIES, FrankaSettings
from tracerisk.vendors.interbotix.driver import InterbotixDriver
from tracerisk.vendors.kinova.driver import FOLLOW_CARTESIAN, KortexDriver
from tracerisk.vendors.niryo.actions import ROBOT_MOVE, TOOL
from tracerisk.vendors.niryo.driver import NiryoRobot
from tracerisk.vendors.rethink.driver import BaxterDriver
from tracerisk.vendors.ufactory.driver import XarmDriver
from tracerisk.vendors.universal_robots.driver import UniversalRobotsBox

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime


def serve_vendors(runtime: Runtime, twin: TwinInterfaces) -> None:
    """Offer each maker's services and actions, and listen to its command topics."""
    messages, commands = twin.messages, runtime.client(TwinCommands)
    InterbotixDriver(runtime, messages, commands)
    XarmDriver(runtime, messages, commands)
    UniversalRobotsBox(runtime, messages, commands)
    BaxterDriver(runtime, messages, commands, twin.set_points)
    franka = FrankaSettings(runtime, messages, commands)
    kortex = KortexDriver(runtime, messages, commands)
    DobotDriver(runtime, messages, commands)
    DoosanController(runtime, messages, commands)
    niryo = NiryoRobot(runtime, messages, commands).actions
    twin.take(
        {
            **dict.fromkeys(RECOVERIES, (franka.recover, franka.on_cancel)),
            FOLLOW_CARTESIAN: (kortex.follow_cartesian, kortex.on_cancel),
            ROBOT_MOVE: (niryo.move, niryo.on_cancel),
            TOOL: (niryo.use_tool, niryo.on_cancel),
        }
    )
