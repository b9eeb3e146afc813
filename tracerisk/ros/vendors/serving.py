"""The drivers of robot makers on the graph, for what their own libraries and controllers ask."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.ros.vendors.described.described_driver import DescribedDriver
from tracerisk.ros.vendors.described.described_parts import lacking_joint
from tracerisk.ros.vendors.description import Driver
from tracerisk.ros.vendors.dobot.driver import DobotDriver
from tracerisk.ros.vendors.doosan.driver import DoosanController
from tracerisk.ros.vendors.driver_search import shipped_drivers
from tracerisk.ros.vendors.interbotix.driver import InterbotixDriver
from tracerisk.ros.vendors.interbotix.old_driver import InterbotixSdk
from tracerisk.ros.vendors.kinova.driver import FOLLOW_CARTESIAN, KortexDriver
from tracerisk.ros.vendors.niryo.actions import ROBOT_MOVE, TOOL
from tracerisk.ros.vendors.niryo.driver import NiryoRobot
from tracerisk.ros.vendors.rethink.driver import BaxterDriver
from tracerisk.ros.vendors.rethink.io_devices import IoDevices
from tracerisk.ros.vendors.universal_robots.driver import ScriptTopics

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime


def serve_vendors(runtime: Runtime, twin: TwinInterfaces, drivers: Sequence[Driver] = ()) -> None:
    """Offer each maker's services and actions, and listen to its command topics.

    `drivers` are those that users describe; they go before the shipped ones.

    Raises:
        DriverError: one of them does not fit the messages that it speaks of.
    """
    messages = twin.messages
    for driver in (*drivers, *shipped_drivers()):
        lacking = lacking_joint(driver, runtime.twin.robot)
        if not lacking:
            DescribedDriver(driver, runtime, messages)
        elif driver.origin != "shipped" and runtime.recorder is not None:
            runtime.recorder.finding(
                "not_simulated",
                f"{driver.file} is not in use: it is of robots with the joint '{lacking}', which "
                f"'{runtime.twin.robot.name}' has not",
                object_name=driver.name,
            )
    InterbotixDriver(runtime, messages)
    InterbotixSdk(runtime, messages)
    BaxterDriver(runtime, messages)
    IoDevices(runtime, messages)
    kortex = KortexDriver(runtime, messages)
    DobotDriver(runtime, messages)
    ScriptTopics(runtime, messages)
    DoosanController(runtime, messages)
    niryo = NiryoRobot(runtime, messages)
    commands = runtime.client(TwinCommands)
    twin.take(
        {
            FOLLOW_CARTESIAN: (kortex.follow_cartesian, kortex.on_cancel),
            ROBOT_MOVE: (niryo.move, commands.cancel),
            TOOL: (niryo.use_tool, commands.cancel),
        }
    )
