"""What a recording of a robot leaves open, as options; and the trace that it gives with them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk import api
from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.sources import named_robot
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, SettingsError
from tracerisk.pipeline.recordings.declared import Declared, parse_effort_unit
from tracerisk.pipeline.recordings.messages import open_recording
from tracerisk.pipeline.recordings.read import read_trace

if TYPE_CHECKING:
    from tracerisk.trace import Trace
    from tracerisk.twin.robots.robot import Robot

_OPTIONS = ("effort_unit", "encoder_step", "joint_states", "commands", "functions", "names")


def add_reading(parser: argparse.ArgumentParser, *, with_robot: bool) -> None:
    """Add what is declared of recordings; the robot too, where no other options have it."""
    group = parser.add_argument_group("recordings of a robot (`tracerisk docs recordings`)")
    if with_robot:
        group.add_argument("--robot", metavar="NAME|FILE", help="the robot that was recorded")
    group.add_argument(
        "--effort-unit",
        metavar="UNIT",
        help="unit of effort: Nm, %%, mA:K or A:K with K in N m per A (default: the robot's)",
    )
    group.add_argument(
        "--encoder-step",
        metavar="RAD",
        type=float,
        help="least difference of two positions [rad or m]; velocities are then derived if missing",
    )
    group.add_argument("--joint-states", metavar="TOPIC", help="the topic of the joint states")
    group = group.add_mutually_exclusive_group()
    group.add_argument(
        "--commands", metavar="FILE", help="what the probe wrote (`tracerisk docs probe`)"
    )
    group.add_argument(
        "--functions", metavar="FILE.csv", help="times of functions: time_s,function[,event]"
    )
    group.add_argument("--names", metavar="TOPIC", help="a topic with the names of functions")


def read_recording(path: Path, options: argparse.Namespace, controller: str | None = None) -> Trace:
    """Return the trace of a recording: that of the run it is of, else what a robot did.

    `controller` is the file of its functions.
    """
    from tracerisk.pipeline.recordings.measured import measured_trace

    trace = read_trace(path)
    if trace is not None:
        given = [name for name in _OPTIONS if getattr(options, name) is not None]
        if given or controller is not None:
            name = f"--{given[0].replace('_', '-')}" if given else "FILE"
            raise InputError(
                f"{name} does not go with the recording of a run, whose trace is read as it is",
                Location(str(path)),
            )
        check_robot(trace, options.robot, path)
        return trace
    robot, declared = _declared(path, options, controller)
    return measured_trace(path, robot, declared)


def check_robot(trace: Trace, name: str | None, path: Path) -> None:
    """Raise InputError where `--robot NAME` is not the robot that a trace is of."""
    if name is None or not trace.robot:
        return
    named = named_robot(name, Path(), Settings()).name
    if named != trace.robot:
        raise InputError(
            f"is the run of robot '{trace.robot}', which its figures are of, and not of '{named}'; "
            f"leave out --robot {name}, or name the recording of that robot",
            Location(str(path)),
        )


def _declared(
    path: Path, options: argparse.Namespace, controller: str | None
) -> tuple[Robot, Declared]:
    settings, file, root = Settings(), "", Path()
    if controller is not None:
        result = api.load_controller(controller)
        settings = api.load_settings(result, shared.run_settings(options))
        file, root = result.file, result.root
    name = options.robot or settings.robot
    with open_recording(path):
        # A file that is no recording is reported first, before what is missing beside it.
        if name is None:
            raise InputError("the robot is not known; name it with --robot", Location(str(path)))
    robot = named_robot(name, root, settings)
    step = options.encoder_step
    if step is not None and not 0.0 < step < 1.0:
        raise SettingsError(f"--encoder-step: {step:g} is not allowed; give 0 to 1 rad (m)")
    unit = options.effort_unit or robot.effort_unit
    commands, functions = (
        None if item is None else Path(item) for item in (options.commands, options.functions)
    )
    return robot, Declared(
        effort_unit=parse_effort_unit(unit) if unit else None,
        encoder_step=step,
        joint_states=options.joint_states,
        commands=commands,
        functions=functions,
        names=options.names,
        controller=file,
        states=settings.states,
        helpers=settings.helpers,
    )
