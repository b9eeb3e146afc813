"""The drivers of robot makers on the graph, for what their own libraries and controllers ask."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from tracerisk.ros.action_graph import ActionGoal
from tracerisk.ros.niryo_actions import ROBOT_MOVE, TOOL
from tracerisk.ros.twin_baxter import BaxterDriver
from tracerisk.ros.twin_commands import TwinCommands
from tracerisk.ros.twin_dobot import DobotDriver
from tracerisk.ros.twin_doosan import DoosanController
from tracerisk.ros.twin_franka import RECOVERIES, FrankaSettings
from tracerisk.ros.twin_gazebo import GazeboServices
from tracerisk.ros.twin_interbotix import InterbotixDriver
from tracerisk.ros.twin_kortex import FOLLOW_CARTESIAN, KortexDriver
from tracerisk.ros.twin_messages import TwinMessages
from tracerisk.ros.twin_niryo import NiryoRobot
from tracerisk.ros.twin_set_points import SetPoints
from tracerisk.ros.twin_universal_robots import UniversalRobotsBox
from tracerisk.ros.twin_xarm import XarmDriver

if TYPE_CHECKING:
    from tracerisk.ros.runtime import Runtime

Handler = Callable[[ActionGoal], None]


def serve_vendors(
    runtime: Runtime, messages: TwinMessages, commands: TwinCommands, set_points: SetPoints
) -> dict[str, tuple[Handler, Handler]]:
    """Offer each vendor's services and listen to its command topics.

    Returns the types of their actions, with what takes a goal and what cancels one.
    """
    InterbotixDriver(runtime, messages, commands)
    XarmDriver(runtime, messages, commands)
    UniversalRobotsBox(runtime, messages, commands)
    if runtime.recorder is not None:
        GazeboServices(runtime, messages, commands)
    BaxterDriver(runtime, messages, commands, set_points)
    franka = FrankaSettings(runtime, messages, commands)
    kortex = KortexDriver(runtime, messages, commands)
    DobotDriver(runtime, messages, commands)
    DoosanController(runtime, messages, commands)
    niryo = NiryoRobot(runtime, messages, commands).actions
    return {
        **dict.fromkeys(RECOVERIES, (franka.recover, franka.on_cancel)),
        FOLLOW_CARTESIAN: (kortex.follow_cartesian, kortex.on_cancel),
        ROBOT_MOVE: (niryo.move, niryo.on_cancel),
        TOOL: (niryo.use_tool, niryo.on_cancel),
    }
