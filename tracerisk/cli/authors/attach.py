"""`tracerisk attach`: listen to a real robot and report which hardware each step used."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from tracerisk.cli.shared import options as shared
from tracerisk.cli.shared.output import note, print_json, show, write_file
from tracerisk.cli.shared.recordings import add_reading, read_recording
from tracerisk.cli.shared.run_report import trace_lines
from tracerisk.cli.shared.values import positive
from tracerisk.common import trace_json
from tracerisk.errors import ExitCode, InputError
from tracerisk.pipeline.recordings.attach import record_robot


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument(
        "controller", metavar="FILE", nargs="?", help="the file of the controller's functions"
    )
    parser.add_argument(
        "--duration",
        metavar="S",
        type=positive,
        help="how long to listen (default: until an interrupt)",
    )
    parser.add_argument(
        "--dds",
        action="store_true",
        help="listen to a robot of ROS 2, by DDS (extra dds; default: ROS 1)",
    )
    parser.add_argument("--keep", metavar="OUT.mcap", help="keep what was heard as a recording")
    add_reading(parser, with_robot=True)
    parser.add_argument("-o", "--output", metavar="FILE", help="write the trace as JSON")
    shared.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the verb and return its exit code."""
    if options.robot is None and options.controller is None:
        raise InputError("--robot is missing: name the robot that is listened to")
    named = (options.names, options.joint_states)
    topics = tuple(item for item in named if item is not None)
    with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
        path = Path(options.keep or Path(folder, "robot.mcap"))
        note("listening; an interrupt ends it", quiet=options.quiet)
        heard = record_robot(path, topics=topics, seconds=options.duration, by_dds=options.dds)
        said = f"{heard.messages} messages on {len(heard.topics)} topics; {heard.ended}"
        note(said, quiet=options.quiet)
        trace = read_recording(path, options, options.controller)
    if options.output is not None:
        write_file(options.output, trace_json.dumps(trace))
    if options.json:
        print_json("attach", exit_code=0, trace=trace_json.trace_data(trace))
        return int(ExitCode.FINE)
    for line in trace_lines(trace):
        show(line)
    for line in trace.assumptions:
        note(f"assumed: {line}", quiet=options.quiet)
    return int(ExitCode.FINE)
