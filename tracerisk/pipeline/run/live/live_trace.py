"""The trace of a controller that runs on real ROS, with the twin as a node beside it."""

from __future__ import annotations

import os
from dataclasses import replace

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.config import Settings
from tracerisk.errors import SandboxError
from tracerisk.pipeline.launch.choose import NOTHING_CHOSEN, choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.controller_run import run_controller
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.pipeline.run.live.command import check_command
from tracerisk.pipeline.run.live.compiled import function_main
from tracerisk.pipeline.trace.sensors import elements_of
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.live.real_ros import python_of_ros
from tracerisk.trace import LIVE, LOST, Trace

_LOST = (
    "repeatability: threads, connections and waits on the wall clock take the time that they take",
    "other nodes of the workspace and drafted values: none are given",
    "transforms, messages and services waited for in vain: no reason of the verdict speaks of it",
    "services and actions of the controller itself: no scenario calls them",
)
_LOST_OF_ROS2 = (
    "timeouts of rclpy's functions: they are on the wall clock; clocks of nodes, their timers and "
    "rates, and time.sleep() follow the twin's time",
)
_LOST_OF_RCLCPP = (
    "clocks besides those of nodes: wall timers, WallRate, rclcpp::sleep_for and timeouts are on "
    "the wall clock; clocks of nodes, their timers and rates follow /clock",
)
_LOST_OF_COMPILED = (
    "what functions do besides commanding: the probe of a compiled node sees a function when it "
    "sends something, so one that ran and sent nothing counts as one that never ran",
    "exceptions that the node caught: errors that it logs are known (ROS_ERROR, RCLCPP_ERROR)",
    "visits: calls of a function are distinguished by the lines and loops of the source",
)


def trace_live(controller: Controller, settings: Settings, options: RunOptions) -> Trace:
    """Run the controller once on real ROS, and return what the run showed.

    One in C or C++ is run by the command that its settings give as arguments.

    Raises:
        InputError: it is compiled, and no command starts its node.
        DependencyError: there is no rospy or rclpy.
        SandboxError: settings require a sandbox, which a live run has not.
    """
    ros = controller.ros_version
    if settings.limits.sandbox.mode == "require":
        raise SandboxError(
            "the sandbox is required, and --live runs the controller outside of it, on a network "
            "of its own; leave out one of the two"
        )
    if not controller.is_python:
        check_command(settings.args, str(controller.path), os.environ, ros)
        function_main(controller.source, str(controller.path))
    python_of_ros(ros)
    settings = with_scenario(settings)
    # What starts compiled nodes gives them what their launch file says.
    launch = choose_launch(controller, settings) if controller.is_python else NOTHING_CHOSEN
    choice = choose_launched_robot(controller, settings, launch)
    bind(load_hardware(settings, choice.robot.name), elements_of(choice.robot, settings))
    done = run_controller(controller, choice.robot, settings, launch, options)
    of_clocks = _LOST_OF_ROS2 if controller.is_python else _LOST_OF_RCLCPP
    more = () if controller.is_python else _LOST_OF_COMPILED
    lost = (*_LOST, *more, *(of_clocks if ros == 2 else ()))
    library = "rclpy" if ros == 2 else "rospy"
    measured = f"{LIVE}, on real {library if controller.is_python else f'ROS {ros}'}"
    assumptions = (f"{measured} with the twin as a node", *(f"{LOST} {name}" for name in lost))
    return replace(done.trace, assumptions=(*assumptions, *done.trace.assumptions))
