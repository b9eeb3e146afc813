"""The trace of a controller that runs on real rospy, with the twin as a node beside it."""

from __future__ import annotations

from dataclasses import replace

from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, SandboxError
from tracerisk.pipeline.launch.choose import choose_launch
from tracerisk.pipeline.robot.choice import choose_launched_robot
from tracerisk.pipeline.robot.scenario_settings import with_scenario
from tracerisk.pipeline.run.controller_run import run_controller
from tracerisk.pipeline.run.ended_run import RunOptions
from tracerisk.pipeline.trace.sensors import elements_of
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.ros.live.real_ros import python_of_ros
from tracerisk.trace import LOST, MEASURED, Trace

_MEASURED = f"{MEASURED} live, on real rospy with the twin as a node"
_LOST = (
    "repeatability: threads, connections and waits on the wall clock take the time that they take",
    "other nodes of the workspace, drafted values and answers to input(): none are given",
    "transforms, messages and services waited for in vain: no reason of the verdict speaks of it",
    "services and actions of the controller itself: no scenario calls them",
)


def trace_live(controller: Controller, settings: Settings, options: RunOptions) -> Trace:
    """Run the controller once on real rospy, and return what the run showed.

    Raises:
        InputError: the controller is not of ROS 1.
        DependencyError: there is no rospy.
        SandboxError: settings require a sandbox, which a live run has not.
    """
    if controller.ros_version == 2:
        raise InputError(
            "is written for ROS 2; --live runs controllers of ROS 1, on rospy",
            Location(str(controller.path)),
        )
    if settings.limits.sandbox.mode == "require":
        raise SandboxError(
            "the sandbox is required, and --live runs the controller outside of it, on a network "
            "of its own; leave out one of the two"
        )
    python_of_ros()
    settings = with_scenario(settings)
    launch = choose_launch(controller, settings)
    choice = choose_launched_robot(controller, settings, launch)
    bind(load_hardware(settings, choice.robot.name), elements_of(choice.robot, settings))
    done = run_controller(controller, choice.robot, settings, launch, options)
    assumptions = (_MEASURED, *(f"{LOST} {name}" for name in _LOST))
    return replace(done.trace, assumptions=(*assumptions, *done.trace.assumptions))
